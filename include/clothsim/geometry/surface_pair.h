#pragma once

#include <array>

#include "clothsim/model/types.h"

namespace clothsim {

/// A point and a triangle of a cloth, or two of its edges, without a point in common. Two points
/// count as edges without length.
struct SurfacePair {
  int triangle;               // b; no_triangle: two edges
  std::array<int, 4> points;  // point a and corners of b, or ends of a and ends of b
  double nearest;             // distance at which they are in contact [m]

  static constexpr int no_triangle = -1;
  bool edges() const { return triangle == no_triangle; }
};

/// The distance of two features and the direction between their closest points.
struct Separation {
  double distance = 0;              // [m]
  Vector3 normal{0, 0, 0};          // from b to a; zero where they meet
  std::array<double, 4> weights{};  // of the pair's points: a's sum up to 1, b's to -1
};

/// The separation at `positions` [m, N x 3].
Separation separation(const SurfacePair&, const Points& positions);

/// How far a lies beyond b along `direction`, a unit vector [m]: at most their distance, and equal
/// to it where `direction` is their normal.
double gap_along(const Vector3& direction, const SurfacePair&, const Points& positions);

/// The least such gap while points go straight from `start` to `end`, N x 3. The direction turns
/// with the features: it is quadratic in time, as a triangle's normal is, and agrees with the
/// features' normal at the start, half way and at the end. The gap between two points of a and b is
/// then a cubic. Returns the least of all coefficients in Bernstein form [m]: where it is positive,
/// a and b do not meet on the way.
double min_gap_turning(const SurfacePair&, const Points& start, const Points& end);

}  // namespace clothsim
