#pragma once

#include <algorithm>
#include <array>

#include "clothsim/geometry/intersections.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/types.h"

// What acts on a triangle at a point of it acts on its corners, in the shares that the point has of
// them.

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

/// Adds a change to the free corners by their weights.
inline void spread(const Cloth& cloth, const Corners& corners, const CornerWeights& weights,
                   const Vector3& change, Points& points) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (cloth.inv_mass[corners[i]] > 0) points.row(corners[i]) += weights[i] * change.transpose();
  }
}

inline double yield_of(const Cloth& cloth, const Corners& corners, const CornerWeights& weights) {
  double yield = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (cloth.inv_mass[corners[i]] > 0) yield += weights[i] * weights[i];
  }
  return yield;
}

inline bool any_held(const Cloth& cloth, const Corners& corners) {
  return std::any_of(corners.begin(), corners.end(), [&](int i) { return cloth.inv_mass[i] == 0; });
}

/// Velocity at a contact over that of the corner which moves fastest for it, where one is held:
/// next to that the free ones have long ways to go. 1 where all are free.
inline double lever_of(const Cloth& cloth, const Corners& corners, const CornerWeights& weights) {
  if (!any_held(cloth, corners)) return 1;
  double largest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (cloth.inv_mass[corners[i]] > 0) largest = std::max(largest, weights[i]);
  }
  return largest > 0 ? yield_of(cloth, corners, weights) / largest : 0;
}

}  // namespace clothsim
