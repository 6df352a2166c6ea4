#include "clothsim/geometry/surface_mesh.h"

#include <algorithm>
#include <cassert>
#include <map>

namespace clothsim {

SurfaceMesh::SurfaceMesh(const Cloth& cloth)
    : cell_columns(cloth.columns - 1), cell_rows(cloth.rows - 1), triangles(cloth.triangles) {
  assert(cell_columns > 0 && cell_rows > 0);
  assert(static_cast<int>(triangles.size()) == 2 * num_cells());
  cell_points.resize(static_cast<std::size_t>(num_cells()));
  cell_edges.resize(static_cast<std::size_t>(num_cells()));
  triangle_of_point.assign(static_cast<std::size_t>(cloth.num_points()), -1);
  triangle_of_edge.resize(triangles.size());

  // The first triangle that has a point or an edge owns it.
  std::map<std::array<int, 2>, int> owners;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int point = triangles[t][k];
      int& owner = triangle_of_point[static_cast<std::size_t>(point)];
      if (owner < 0) {
        owner = static_cast<int>(t);
        cell_points[t / 2].push_back(point);
      }

      std::array<int, 2> edge{triangles[t][(k + 1) % 3], triangles[t][(k + 2) % 3]};
      if (edge[0] > edge[1]) std::swap(edge[0], edge[1]);
      const auto [found, is_new] = owners.emplace(edge, static_cast<int>(t));
      if (is_new) {
        cell_edges[t / 2].push_back(static_cast<int>(edges.size()));
        edges.push_back(edge);
      }
      triangle_of_edge[t][k] = found->second;
    }
  }
}

}  // namespace clothsim
