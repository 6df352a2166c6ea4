#pragma once

#include <array>

#include "clothsim/model/types.h"

namespace clothsim {

/// A point and a triangle of a cloth, or two of its edges, that share no point. Two points count as
/// edges without length.
struct SurfacePair {
  int triangle;               // b; no_triangle: two edges
  std::array<int, 4> points;  // point a and corners of b, or ends of a and ends of b
  double nearest;             // how near they may come [m]

  static constexpr int no_triangle = -1;
  bool edges() const { return triangle == no_triangle; }
};

/// How two features lie to each other where they are closest.
struct Separation {
  double distance = 0;              // [m]
  Vector3 normal{0, 0, 0};          // from b to a; zero where they meet
  std::array<double, 4> weights{};  // of the pair's points: a's sum up to 1, b's to -1
};

/// At `positions` [m, N x 3].
Separation separation(const SurfacePair&, const Points& positions);

/// How far a lies beyond b along `direction`, a unit vector: never more than their distance, and as
/// much where the direction is their normal [m].
double gap_along(const Vector3& direction, const SurfacePair&, const Points& positions);

/// The same while points go straight from `start` to `end`, N x 3, along a direction that turns
/// with the features, as quadratic in time as a triangle's normal: through theirs at the start,
/// half way and at the end. For two points, of a and b, that is a cubic. Returns the least of all
/// coefficients in Bernstein's form [m]: where it is positive, a and b do not meet on the way.
double min_gap_turning(const SurfacePair&, const Points& start, const Points& end);

}  // namespace clothsim
