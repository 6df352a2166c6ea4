#pragma once

#include <algorithm>
#include <array>

#include "clothsim/geometry/intersections.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/types.h"

// A force or impulse at a point of a triangle acts on the corners in proportion to the barycentric
// weights of that point.

namespace clothsim {

using Corners = std::array<int, 3>;  // points of a cloth
using CornerWeights = std::array<double, 3>;

inline Triangle triangle_of(const Points& points, const Corners& corners) {
  return {points.row(corners[0]), points.row(corners[1]), points.row(corners[2])};
}

/// Sum of rows by weights.
inline Vector3 weighted(const Points& points, const Corners& corners,
                        const CornerWeights& weights) {
  return (weights[0] * points.row(corners[0]) + weights[1] * points.row(corners[1]) +
          weights[2] * points.row(corners[2]))
      .transpose();
}

/// Displacements of the corners by an impulse at a point of a triangle: the point's weight times
/// inverse mass, over the largest inverse mass of a corner. 0 for held corners.
inline CornerWeights moves_of(const Cloth& cloth, const Corners& corners,
                              const CornerWeights& weights) {
  double largest = 0;
  for (const int i : corners) largest = std::max(largest, cloth.inv_mass[i]);
  CornerWeights moves{};
  if (largest == 0) return moves;
  for (std::size_t i = 0; i < 3; ++i) {
    moves[i] = weights[i] * (cloth.inv_mass[corners[i]] / largest);
  }
  return moves;
}

/// Adds a change to the corners in proportion to `moves`.
inline void spread(const Corners& corners, const CornerWeights& moves, const Vector3& change,
                   Points& points) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (moves[i] > 0) points.row(corners[i]) += moves[i] * change.transpose();
  }
}

/// Velocity at the point with these weights, per impulse there.
inline double inv_effective_mass_of(const CornerWeights& weights, const CornerWeights& moves) {
  return weights[0] * moves[0] + weights[1] * moves[1] + weights[2] * moves[2];
}

inline bool any_held(const Cloth& cloth, const Corners& corners) {
  return std::any_of(corners.begin(), corners.end(), [&](int i) { return cloth.inv_mass[i] == 0; });
}

/// Velocity at a contact over that of its fastest corner, where a corner is held: near a held
/// corner the free ones move far. 1 where all are free.
inline double lever_of(const Cloth& cloth, const Corners& corners, const CornerWeights& weights) {
  if (!any_held(cloth, corners)) return 1;
  const CornerWeights moves = moves_of(cloth, corners, weights);
  const double largest = *std::max_element(moves.begin(), moves.end());
  return largest > 0 ? inv_effective_mass_of(weights, moves) / largest : 0;
}

}  // namespace clothsim
