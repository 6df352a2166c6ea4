#pragma once

#include <array>

#include "clothsim/geometry/box_tree.h"

namespace clothsim {

/// Where the ray o + t d, t > 0, passes through the triangle: t, infinity where it does not. Moller
/// & Trumbore 1997, "Fast, minimum storage ray/triangle intersection".
double hit_by_ray(const Vector3& o, const Vector3& d, const std::array<Vector3, 3>& triangle);

/// Where it enters the box, 0 where it begins in it.
double hit_by_ray(const Vector3& o, const Vector3& d, const Box& box);

}  // namespace clothsim
