#include "clothsim/search/feature_pairs.h"

#include <algorithm>

namespace clothsim {
namespace {

bool is_empty(const FeaturePairs::List& list) { return list[0].empty() && list[1].empty(); }

}  // namespace

FeaturePairs::FeaturePairs(const SurfaceMesh& mesh) {
  for (int r = 0; r < mesh.cell_rows; ++r) {
    for (int c = 0; c < mesh.cell_columns; ++c) {
      places_.push_back(
          {c, r, r * (mesh.cell_columns + 1) + c, (c == 0 ? 1 : 0) + (r == 0 ? 2 : 0)});
    }
  }

  // One list by kinds and way, from the first two cells that have them. Those of the first three
  // rows and columns have all that there are.
  std::vector<int> cells;
  for (int r = 0; r < std::min(3, mesh.cell_rows); ++r) {
    for (int c = 0; c < std::min(3, mesh.cell_columns); ++c) {
      cells.push_back(r * mesh.cell_columns + c);
    }
  }
  for (const int cell : cells) {
    for (const int other : cells) {
      const std::size_t here = number(cell, other);
      List& far = lists_[here - way(cell, other) + far_way];
      if (is_empty(far)) far = list(mesh, cell, other, true);
      if (is_empty(lists_[here])) lists_[here] = list(mesh, cell, other, false);
    }
  }
}

std::size_t FeaturePairs::way(int cell, int other) const {
  const int columns = place(other).column - place(cell).column;
  const int rows = place(other).row - place(cell).row;
  if (std::max(std::abs(columns), std::abs(rows)) > 1) return far_way;
  return static_cast<std::size_t>(3 * (rows + 1) + columns + 1);
}

/// What two cells have together; if they are `apart`, they cannot share a point.
FeaturePairs::List FeaturePairs::list(const SurfaceMesh& mesh, int cell, int other,
                                      bool apart) const {
  const std::array<int, 2> cells{cell, other};
  const bool alone = cell == other && !apart;
  List result;
  const auto add = [&](bool edges, const std::array<int, 4>& points,
                       const std::array<std::size_t, 4>& of, int triangle) {
    const auto begin_b = points.begin() + (edges ? 2 : 1);
    const bool share = std::any_of(points.begin(), begin_b, [&](int point) {
      return std::find(begin_b, points.end(), point) != points.end();
    });
    if (share && !apart) return;
    Pair pair{points, of, triangle};
    for (std::size_t k = 0; k < 4; ++k) pair.points[k] -= first_point(cells[of[k]]);
    result[edges].push_back(pair);
  };

  for (const std::size_t a : {0u, 1u}) {
    if (alone && a == 1) continue;
    const std::size_t b = 1 - a;
    for (const int point : mesh.cell_points[static_cast<std::size_t>(cells[a])]) {
      for (const int t : {0, 1}) {
        const auto& [p, q, r] = mesh.triangles[static_cast<std::size_t>(2 * cells[b] + t)];
        add(false, {point, p, q, r}, {a, b, b, b}, t);
      }
    }
  }

  const auto& edges = mesh.cell_edges[static_cast<std::size_t>(cell)];
  const auto& others = mesh.cell_edges[static_cast<std::size_t>(other)];
  for (std::size_t i = 0; i < edges.size(); ++i) {
    for (std::size_t j = alone ? i + 1 : 0; j < others.size(); ++j) {
      const auto& [a, b] = mesh.edges[static_cast<std::size_t>(edges[i])];
      const auto& [c, d] = mesh.edges[static_cast<std::size_t>(others[j])];
      add(true, {a, b, c, d}, {0, 0, 1, 1}, SurfacePair::no_triangle);
    }
  }
  return result;
}

}  // namespace clothsim
