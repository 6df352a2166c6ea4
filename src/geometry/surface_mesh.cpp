#include "clothsim/geometry/surface_mesh.h"

#include <cassert>
#include <map>

namespace clothsim {

SurfaceMesh::SurfaceMesh(const Cloth& cloth)
    : triangles(cloth.triangles),
      across(triangles.size(), {none, none, none}),
      around_point(static_cast<std::size_t>(cloth.num_points())) {
  assert(cloth.columns > 1 && cloth.rows > 1);
  // Where an edge was seen first: its triangle and the corner opposite.
  std::map<std::array<int, 2>, std::array<std::size_t, 2>> seen;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      around_point[static_cast<std::size_t>(triangles[t][k])].push_back(static_cast<int>(t));
      std::array<int, 2> edge{triangles[t][(k + 1) % 3], triangles[t][(k + 2) % 3]};
      if (edge[0] > edge[1]) std::swap(edge[0], edge[1]);
      const auto [found, is_new] = seen.emplace(edge, std::array<std::size_t, 2>{t, k});
      if (is_new) {
        edges.push_back(edge);
      } else {
        const auto& [other, corner] = found->second;
        across[t][k] = static_cast<int>(other);
        across[other][corner] = static_cast<int>(t);
      }
    }
  }
}

}  // namespace clothsim
