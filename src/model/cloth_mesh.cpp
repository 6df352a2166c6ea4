#include "clothsim/model/cloth_mesh.h"

#include <algorithm>
#include <string>
#include <tuple>

#include "clothsim/model/errors.h"

namespace clothsim {

std::vector<MeshEdge> mesh_edges(const std::vector<std::array<int, 3>>& triangles) {
  std::vector<std::tuple<int, int, int>> sides;  // ends ascending, triangle
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(triangles[t][k], triangles[t][(k + 1) % 3]);
      sides.emplace_back(a, b, static_cast<int>(t));
    }
  }
  std::sort(sides.begin(), sides.end());
  std::vector<MeshEdge> edges;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const auto [a, b, t] = sides[i];
    if (!edges.empty() && edges.back().points == std::array<int, 2>{a, b}) {
      if (edges.back().triangles[1] >= 0) {
        throw InvalidValue(
            {},
            "an edge of three triangles, " + std::to_string(edges.back().triangles[0]) + ", " +
                std::to_string(edges.back().triangles[1]) + " and " + std::to_string(t) +
                ", between points " + std::to_string(a) + " and " + std::to_string(b),
            "at most two triangles at an edge");
      }
      edges.back().triangles[1] = t;
    } else {
      edges.push_back({{a, b}, {t, -1}});
    }
  }
  return edges;
}

}  // namespace clothsim
