#pragma once

#include "clothsim/model/types.h"

namespace clothsim {

/// Second derivative [N/m] of a spring's energy k (l - L0)^2 / 2 by the vector d [m] from one end
/// to the other, l = |d|, u = d / l:
///   k (u u^T + max(1 - L0 / l, min_across) (I - u u^T)).
/// Without `min_across` it is exact, and indefinite where l < L0. With 0 it is positive
/// semidefinite (Teran et al. 2005, "Robust quasistatic finite elements"). Zero where l = 0, as the
/// force is.
Eigen::Matrix3d spring_hessian(double stiffness, double rest_length, const Vector3& d,
                               double min_across = -infinity);

}  // namespace clothsim
