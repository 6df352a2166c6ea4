#include "clothsim/geometry/surface_mesh.h"

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "clothsim/model/errors.h"

namespace clothsim {

SurfaceMesh::SurfaceMesh(int points, std::vector<std::array<int, 3>> of)
    : triangles(std::move(of)), around_point(static_cast<std::size_t>(points)) {
  std::set<std::array<int, 2>> seen;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& [a, b, c] = triangles[t];
    if (std::min({a, b, c}) < 0 || std::max({a, b, c}) >= points || a == b || b == c || a == c) {
      throw InvalidValue({"triangles"},
                         "triangle " + std::to_string(t) + " of points " + std::to_string(a) +
                             ", " + std::to_string(b) + " and " + std::to_string(c),
                         "three of " + std::to_string(points));
    }
    for (std::size_t k = 0; k < 3; ++k) {
      around_point[static_cast<std::size_t>(triangles[t][k])].push_back(static_cast<int>(t));
      std::array<int, 2> edge{triangles[t][(k + 1) % 3], triangles[t][(k + 2) % 3]};
      if (edge[0] > edge[1]) std::swap(edge[0], edge[1]);
      if (seen.insert(edge).second) edges.push_back(edge);
    }
  }
}

}  // namespace clothsim
