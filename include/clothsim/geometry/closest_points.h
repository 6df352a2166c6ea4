#pragma once

#include <array>

#include "clothsim/model/types.h"

namespace clothsim {

/// Square of the sine below which two directions are parallel: beyond, rounding decides where they
/// are closest, and what is square to both.
inline constexpr double parallel = 1e-14;

/// Weights of a triangle's corners at its point closest to `p`: >= 0, their sum 1, exactly 0 for
/// corners that the closest edge or corner does not have. A triangle without area is its longest
/// edge, or a point. Ericson, Real-Time Collision Detection, 5.1.5.
std::array<double, 3> closest_on_triangle(const Vector3& p, const Vector3& a, const Vector3& b,
                                          const Vector3& c);

/// Where on two segments, from 0 at their first ends to 1, their closest points lie. Of parallel
/// ones, one such pair; a segment without length is a point. Ericson, 5.1.9.
struct SegmentParameters {
  double s;  // on p
  double t;  // on q
};
SegmentParameters closest_on_segments(const Vector3& p0, const Vector3& p1, const Vector3& q0,
                                      const Vector3& q1);

}  // namespace clothsim
