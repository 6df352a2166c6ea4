#pragma once

#include "clothsim/shapes/face_distance.h"

namespace clothsim {

/// face_distance() of a triangle outside a convex shape, searched from the weights of the place
/// that was nearest before the triangle moved. The shape's tangent plane there separates both, so
/// that no other place is nearer. Empty where a few steps find no such place, or the shape is not
/// convex.
std::optional<FaceDistance> tracked_distance(const Shape&, const Triangle&,
                                             const std::array<double, 3>& start);

}  // namespace clothsim
