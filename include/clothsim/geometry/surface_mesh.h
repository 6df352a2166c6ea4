#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "clothsim/model/cloth.h"

namespace clothsim {

/// Triangles between points, their edges, and the triangles around each point.
struct SurfaceMesh {
  /// `triangles`: three points each. Throws InvalidValue for points out of range or repeated.
  SurfaceMesh(int points, std::vector<std::array<int, 3>> triangles);
  explicit SurfaceMesh(const Cloth& cloth) : SurfaceMesh(cloth.num_points(), cloth.triangles) {
    first_points = cloth.first_points;
  }

  /// Number of the cloth that a point is of; 0 where there is one.
  int cloth_of(int point) const {
    const auto next = std::upper_bound(first_points.begin(), first_points.end(), point);
    return std::max(0, static_cast<int>(next - first_points.begin()) - 1);
  }

  std::vector<std::array<int, 3>> triangles;  // points
  std::vector<std::array<int, 2>> edges;      // points, ascending; each edge once

  std::vector<std::vector<int>> around_point;  // triangles that have it, ascending
  std::vector<int> first_points;               // of several cloths; empty: one
};

}  // namespace clothsim
