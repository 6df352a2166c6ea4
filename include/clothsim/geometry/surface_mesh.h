#pragma once

#include <array>
#include <vector>

#include "clothsim/model/cloth.h"

namespace clothsim {

/// Points, edges and triangles of a cloth, and which of these a point has. Needs two columns and
/// two rows at least.
struct SurfaceMesh {
  SurfaceMesh() = default;
  explicit SurfaceMesh(const Cloth&);

  std::vector<std::array<int, 3>> triangles;  // points
  std::vector<std::array<int, 2>> edges;      // points, ascending; each edge once

  std::vector<std::vector<int>> around_point;  // triangles that have it, ascending
};

}  // namespace clothsim
