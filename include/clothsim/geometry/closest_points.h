#pragma once

#include <array>

#include "clothsim/model/types.h"

namespace clothsim {

/// Squared sine below which two directions count as parallel: below it, their closest points and
/// common perpendicular are rounding.
inline constexpr double parallel = 1e-14;

/// Barycentric coordinates of a triangle's point closest to `p`: >= 0, their sum 1, exactly 0 for
/// corners that are not on the closest edge or corner. A triangle without area counts as its
/// longest edge, or a point. Ericson, Real-Time Collision Detection, 5.1.5.
std::array<double, 3> closest_on_triangle(const Vector3& p, const Vector3& a, const Vector3& b,
                                          const Vector3& c);

/// The closest points of two segments, as shares from 0 to 1 along each. For parallel segments, one
/// such pair; a segment without length counts as a point. Ericson, 5.1.9.
struct SegmentParameters {
  double s;  // on p
  double t;  // on q
};
SegmentParameters closest_on_segments(const Vector3& p0, const Vector3& p1, const Vector3& q0,
                                      const Vector3& q1);

}  // namespace clothsim
