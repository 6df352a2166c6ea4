#pragma once

#include <array>

#include "clothsim/model/triangle_fabric.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// Angles below the first [rad], and neighbours nearer to a triangle's plane than the second [m],
/// are taken for rounding of a file: numbers of six decimals, or of single precision.
inline constexpr double least_angle = 1e-4;
inline constexpr double least_offset = 2e-6;

/// The angle across an edge from corner k of a triangle to the next one [rad]: that of the other
/// triangle, with the corner `far`, to the plane of this one, positive to the side of its normal.
double angle_across(const std::array<Vector3, 3>& corners, std::size_t k, const Vector3& far);

/// Makes the shape with its points at `places` the rest shape of a bend: its curvature becomes that
/// along the triangle's normal. A bend has also a part in the triangle's plane, of the second order
/// in the angles to its neighbours; the coefficients of the corners change by the multiples of both
/// sides that remove it.
void keep_curvature(const std::array<Vector3, PatchBend::near>& places, PatchBend& bend);

/// Sums the bends with a curvature at rest by triangle: sets fabric.curved. `fabric` has its pairs.
void add_curved_triangles(TriangleFabric& fabric);

}  // namespace clothsim
