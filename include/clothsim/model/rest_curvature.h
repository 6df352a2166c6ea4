#pragma once

#include "clothsim/model/triangle_fabric.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// Makes the shape at `positions` the rest shape of a bend: its curvature becomes that in the
/// direction of the triangle's normal. A bend has also a part in the triangle's plane, of the
/// second order in the angles to its neighbours; the coefficients of the corners change by the
/// multiples of both sides that remove it. Nothing changes where the triangle and its neighbours
/// are flat.
void keep_curvature(const Points& positions, PatchBend& bend);

/// Sums the bends with a curvature at rest by triangle: sets fabric.curved. `fabric` has its pairs.
void add_curved_triangles(TriangleFabric& fabric);

}  // namespace clothsim
