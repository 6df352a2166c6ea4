#include "clothsim/collision/feature_pairs.h"

#include <algorithm>
#include <cassert>

namespace clothsim {

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
      auto& lists = lists_[kind(cell)][kind(other)];
      if (lists[far_way].empty()) lists[far_way] = list(mesh, cell, other, true);
      Runs& runs = lists[way(cell, other)];
      if (runs.empty()) runs = list(mesh, cell, other, false);
    }
  }
}

const FeaturePairs::Runs& FeaturePairs::of(int cell, int other) const {
  return lists_[kind(cell)][kind(other)][way(cell, other)];
}

std::size_t FeaturePairs::way(int cell, int other) const {
  const int columns = place(other).column - place(cell).column;
  const int rows = place(other).row - place(cell).row;
  if (std::max(std::abs(columns), std::abs(rows)) > 1) return far_way;
  return static_cast<std::size_t>(3 * (rows + 1) + columns + 1);
}

/// What two cells have together; if they are `apart`, they cannot share a point.
FeaturePairs::Runs FeaturePairs::list(const SurfaceMesh& mesh, int cell, int other,
                                      bool apart) const {
  const std::array<int, 2> cells{cell, other};
  const std::array<int, 2> first = first_points(cell, other);
  const auto add = [&](Run& run, const std::array<int, 4>& points) {
    const std::size_t of_a = run.edges ? 2 : 1;
    const auto begin_b = points.begin() + of_a;
    const bool share = std::any_of(points.begin(), begin_b, [&](int point) {
      return std::find(begin_b, points.end(), point) != points.end();
    });
    if (share && !apart) return false;
    for (std::size_t k = 0; k < 4; ++k) run.points[k].push_back(points[k] - first[run.of_point(k)]);
    return true;
  };
  const bool alone = cell == other && !apart;

  Runs runs;
  for (std::size_t a : {0u, 1u}) {
    if (alone && a == 1) continue;
    Run run{false, {a, 1 - a}, {}, {}};
    const auto& points = mesh.cell_points[static_cast<std::size_t>(cells[a])];
    for (const int point : points) {
      for (const int t : {0, 1}) {
        const auto& [b, c, d] = mesh.triangles[static_cast<std::size_t>(2 * cells[1 - a] + t)];
        if (add(run, {point, b, c, d})) run.triangles.push_back(t);
      }
    }
    runs.push_back(std::move(run));
  }

  Run run{true, {0, 1}, {}, {}};
  const auto& edges = mesh.cell_edges[static_cast<std::size_t>(cell)];
  const auto& others = mesh.cell_edges[static_cast<std::size_t>(other)];
  for (std::size_t i = 0; i < edges.size(); ++i) {
    for (std::size_t j = alone ? i + 1 : 0; j < others.size(); ++j) {
      const auto& [a, b] = mesh.edges[static_cast<std::size_t>(edges[i])];
      const auto& [c, d] = mesh.edges[static_cast<std::size_t>(others[j])];
      add(run, {a, b, c, d});
    }
  }
  runs.push_back(std::move(run));
  assert(std::all_of(runs.begin(), runs.end(), [](const Run& r) { return r.size() <= most; }));
  return runs;
}

}  // namespace clothsim
