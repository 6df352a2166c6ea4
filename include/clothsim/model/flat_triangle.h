#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "clothsim/model/cloth_mesh.h"

namespace clothsim {

/// A triangle at rest in its plane: its corners in the order of ClothMesh::triangles [m].
using FlatTriangle = std::array<ClothMesh::Flat, 3>;

inline double cross(const ClothMesh::Flat& a, const ClothMesh::Flat& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Edge k, from corner k to corner k + 1.
inline ClothMesh::Flat edge(const FlatTriangle& x, std::size_t k) { return x[(k + 1) % 3] - x[k]; }

/// Ratio of the height over the longest side to that side.
inline double height_ratio(const FlatTriangle& x) {
  const double longest2 =
      std::max({edge(x, 0).squaredNorm(), edge(x, 1).squaredNorm(), edge(x, 2).squaredNorm()});
  return std::abs(cross(x[1] - x[0], x[2] - x[0])) / longest2;
}

/// Below this ratio small shares of heights would be large curvatures, with frequencies of bending
/// up to ten times as high: slopes at the edges of such a triangle are not corrected.
inline constexpr double least_height_ratio = 0.1;

}  // namespace clothsim
