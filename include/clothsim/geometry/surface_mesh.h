#pragma once

#include <array>
#include <vector>

#include "clothsim/model/cloth.h"

namespace clothsim {

/// Triangles between points, their edges, and the triangles around each point.
struct SurfaceMesh {
  /// `triangles`: three points each. Throws InvalidValue for points out of range or repeated.
  SurfaceMesh(int points, std::vector<std::array<int, 3>> triangles);
  explicit SurfaceMesh(const Cloth& cloth) : SurfaceMesh(cloth.num_points(), cloth.triangles) {}

  std::vector<std::array<int, 3>> triangles;  // points
  std::vector<std::array<int, 2>> edges;      // points, ascending; each edge once

  std::vector<std::vector<int>> around_point;  // triangles that have it, ascending
};

}  // namespace clothsim
