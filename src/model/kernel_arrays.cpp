// The arrays of a fabric on a mesh that kernels take, from its triangles, edges and pairs.

#include <array>
#include <utility>
#include <vector>

#include "clothsim/model/triangle_fabric.h"

namespace clothsim {
namespace {

void add_edge_links(int points, TriangleFabric& fabric) {
  std::vector<std::vector<TriangleFabric::EdgeLink>> of_point(static_cast<std::size_t>(points));
  for (std::size_t e = 0; e < fabric.edges.size(); ++e) {
    const auto& [a, b] = fabric.edges[e];
    of_point[static_cast<std::size_t>(a)].push_back({b, static_cast<int>(e)});
    of_point[static_cast<std::size_t>(b)].push_back({a, static_cast<int>(e)});
    fabric.edge_damping.push_back(2 * fabric.internal_damping_at(a)[0]);
    fabric.edge_weights.push_back(fabric.pairs.empty() ? 0 : fabric.pairs[e].weight);
  }
  for (const auto& links : of_point) {
    fabric.first_links.push_back(static_cast<int>(fabric.edge_links.size()));
    fabric.edge_links.insert(fabric.edge_links.end(), links.begin(), links.end());
  }
  fabric.first_links.push_back(static_cast<int>(fabric.edge_links.size()));
}

void add_bend_links(int points, TriangleFabric& fabric) {
  std::vector<std::vector<std::pair<int, double>>> of_point(static_cast<std::size_t>(points));
  for (std::size_t p = fabric.edges.size(); p < fabric.pairs.size(); ++p) {
    const auto& [i, j, weight] = fabric.pairs[p];
    of_point[static_cast<std::size_t>(i)].emplace_back(j, weight);
    of_point[static_cast<std::size_t>(j)].emplace_back(i, weight);
  }
  auto& [others, weights, first] = fabric.bend_links;
  for (const auto& links : of_point) {
    first.push_back(static_cast<int>(others.size()));
    for (const auto& [other, weight] : links) {
      others.push_back(other);
      weights.push_back(weight);
    }
  }
  first.push_back(static_cast<int>(others.size()));
}

void add_blocks(TriangleFabric& fabric) {
  fabric.blocks.resize(static_cast<std::size_t>(fabric.num_blocks()));
  for (std::size_t t = 0; t < fabric.triangles.size(); ++t) {
    const TriangleFabric::Triangle& triangle = fabric.triangles[t];
    TriangleFabric::Block& block = fabric.blocks[t / TriangleFabric::Block::size];
    const std::size_t lane = t % TriangleFabric::Block::size;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      block.edges[k][lane] = triangle.edges[k];
      block.rest2[k][lane] = triangle.rest2[i];
      block.stretch[k][lane] = triangle.stretch(i, i);
    }
    block.stretch[3][lane] = triangle.stretch(0, 1);
    block.stretch[4][lane] = triangle.stretch(0, 2);
    block.stretch[5][lane] = triangle.stretch(1, 2);
  }
}

}  // namespace

void add_kernel_arrays(int points, TriangleFabric& fabric) {
  add_edge_links(points, fabric);
  add_bend_links(points, fabric);
  add_blocks(fabric);
}

}  // namespace clothsim
