#pragma once

#include "clothsim/model/cloth.h"
#include "clothsim/model/types.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// Adds the forces of the terms of CurvedTriangle to those of the bends' pairs [N]. `positions`:
/// four numbers a point, the first three are its coordinates.
void add_curved_forces(const TriangleFabric&, const double* positions, const Workers&,
                       Points& forces);

/// Adds to `sums`, by point, Gershgorin's row sums of the terms of CurvedTriangle that are
/// quadratic in changes of normals [N/m]: S |dn|^2, and at most 5 |sum of k B (b - B n)| |dn|^2
/// for the second derivative of n, since |d^2 n| <= 3 |dN|^2 / |N|^2 + |d^2 N| / |N|, each at
/// most the square of sum |dn / dx_i| |dx_i|, times 3 and 2.
void add_curved_sums(const Cloth&, const Points& positions, Scalars& sums);

}  // namespace clothsim
