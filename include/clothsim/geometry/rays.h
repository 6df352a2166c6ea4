#pragma once

#include <array>

#include "clothsim/geometry/box_tree.h"

namespace clothsim {

/// Smallest t > 0 at which the ray o + t d passes through the triangle, infinity where it does not.
/// Moller & Trumbore 1997, "Fast, minimum storage ray/triangle intersection".
double hit_by_ray(const Vector3& o, const Vector3& d, const std::array<Vector3, 3>& triangle);

/// The t at which the ray enters the box, 0 where it begins inside, infinity where it misses.
double hit_by_ray(const Vector3& o, const Vector3& d, const Box& box);

}  // namespace clothsim
