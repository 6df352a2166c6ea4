#pragma once

#include <array>

#include "clothsim/model/types.h"

namespace clothsim {

/// A point and a triangle of a cloth, or two of its edges, that share no point.
struct SurfacePair {
  bool edges;                 // two edges
  int a;                      // point, or edge
  int b;                      // triangle, or edge
  std::array<int, 4> points;  // point and corners, or ends of a and ends of b
  double nearest;             // how near they may come [m]
};

/// How two features lie to each other where they are closest.
struct Separation {
  double distance;                // [m]
  Vector3 normal;                 // from b to a; zero where they meet
  std::array<double, 4> weights;  // of the pair's points: a's sum up to 1, b's to -1
};

/// At `positions` [m, N x 3].
Separation separation(const SurfacePair&, const Points& positions);

/// How far a lies beyond b along `direction`, a unit vector: never more than their distance, and as
/// much where the direction is their normal [m].
double gap_along(const Vector3& direction, const SurfacePair&, const Points& positions);

}  // namespace clothsim
