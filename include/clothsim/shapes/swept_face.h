#pragma once

#include <optional>

#include "clothsim/shapes/face_distance.h"
#include "clothsim/shapes/moving_collider.h"

namespace clothsim {

/// Where a triangle whose corners move in straight lines `from` -> `to` in the world, during the
/// last advance() of the collider, first comes within `offset` [m] of it from outside: normal and
/// weights there, in the collider's own frame; `value` is the distance at the end of the step along
/// that normal, so negative for a triangle that went through. Empty where it stays out.
/// Conservative advancement (Mirtich 1996): no step is longer than the remaining distance.
std::optional<FaceDistance> swept_face_distance(const MovingCollider&, const Triangle& from,
                                                const Triangle& to, double offset);

}  // namespace clothsim
