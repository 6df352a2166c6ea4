#pragma once

#include "clothsim/dynamics/internal_damping.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// The function that an implicit step minimises over displacements d of the free points [m], N x 3:
///   sum_i w_i |d_i|^2 / 2 + elastic energy at y + d + damping_potential() there [J],
/// with weights w [N/m], zero at pins (Martin et al. 2011, "Example-based elastic materials", 3.2).
double incremental_potential(const Cloth&, const Scalars& weights, const Points& y, const Points& d,
                             const Past& past = {});

/// Its derivative by d [N], with `positions` = y + d; zero at pins.
void potential_gradient(const Cloth&, const Scalars& weights, const Points& positions,
                        const Points& d, Points& gradient, const Past& past = {});

}  // namespace clothsim
