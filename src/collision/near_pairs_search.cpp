// Candidates of two patches sought anew: near_pairs.cpp says when.

#include <algorithm>
#include <cmath>
#include <limits>

#include "clothsim/collision/near_pairs.h"

namespace clothsim {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Slack of neighbours, of the least distance at rest.
constexpr double slack_share = 0.23;

/// Slack of others, of the contact distance.
constexpr double far_slack_share = 0.5;

/// Most pairs of features of two cells.
constexpr std::uint64_t most_of_cells = 64;

template <typename List>
Box around(const Points& positions, const List& points) {
  Box box;
  for (const int i : points) box.extend(row(positions, i));
  return box;
}

bool share_a_point(const SurfacePair& pair) {
  const auto& [a, b, c, d] = pair.points;
  return pair.edges ? a == c || a == d || b == c || b == d : a == b || a == c || a == d;
}

template <typename T>
const T& of(const std::vector<T>& list, int i) {
  return list[static_cast<std::size_t>(i)];
}

}  // namespace

/// Starts the pair anew. False where the patches are so far from each other that they have no
/// candidates.
bool NearPairs::is_to_be_sought(const Points& positions, PatchPair& pair) const {
  pair.candidates.clear();
  pair.wake_at.clear();
  pair.moved = 0;
  pair.least_wake = infinity;
  pair.least_nearest = infinity;

  const double reach = contact_ + margin_;
  const Box p = around(positions, of(patches_, pair.p).points);
  const Box q = around(positions, of(patches_, pair.q).points);
  const double apart = std::sqrt(p.squaredExteriorDistance(q));
  const double slack = slack_share * least_rest_distance_;
  const double far_slack = std::max(slack, far_slack_share * contact_);
  const bool is_near = apart <= reach + far_slack;
  pair.allowance = !is_near ? apart - reach : are_neighbours(pair) ? slack : far_slack;
  return is_near;
}

/// Are they so near on the cloth that they may touch at rest, but for the neighbours' share?
bool NearPairs::are_neighbours(const PatchPair& pair) const {
  const std::vector<int>& p = of(patches_, pair.p).cells;
  const std::vector<int>& q = of(patches_, pair.q).cells;
  const int columns = mesh_.cell_columns;
  const int window = static_cast<int>(std::ceil((contact_ + margin_) / spacing_));
  const auto gap = [](int a_first, int a_last, int b_first, int b_last) {
    return std::max(b_first - a_last, a_first - b_last);
  };
  return gap(p.front() % columns, p.back() % columns, q.front() % columns, q.back() % columns) <=
             window &&
         gap(p.front() / columns, p.back() / columns, q.front() / columns, q.back() / columns) <=
             window;
}

/// Boxes and gradients of the cells that a search will look at.
void NearPairs::bound_cells(const Cloth& cloth, const Points& positions, const Workers& workers) {
  const int columns = mesh_.cell_columns;
  for (const int cell : bounded_) is_bounded_[static_cast<std::size_t>(cell)] = 0;
  bounded_.clear();
  const auto add = [&](int first_row, int last_row, int first_column, int last_column) {
    for (int r = first_row; r <= last_row; ++r) {
      for (int c = first_column; c <= last_column; ++c) {
        char& is_bounded = is_bounded_[static_cast<std::size_t>(r * columns + c)];
        if (!is_bounded) bounded_.push_back(r * columns + c);
        is_bounded = 1;
      }
    }
  };
  for (const PatchPair& pair : patch_pairs_) {
    if (!pair.is_sought) continue;
    const std::vector<int>& p = of(patches_, pair.p).cells;
    const std::vector<int>& q = of(patches_, pair.q).cells;
    if (are_neighbours(pair)) {  // proofs look at what is between, too
      const auto [first_column, last_column] = std::minmax(
          {p.front() % columns, p.back() % columns, q.front() % columns, q.back() % columns});
      const int last_row = std::max(p.back(), q.back()) / columns;
      add(std::min(p.front(), q.front()) / columns, last_row, first_column, last_column);
    } else {
      for (const auto* cells : {&p, &q}) {
        add(cells->front() / columns, cells->back() / columns, cells->front() % columns,
            cells->back() % columns);
      }
    }
  }
  constexpr int least = 64;
  workers.share(
      static_cast<int>(bounded_.size()),
      [&](int begin, int end) {
        for (int k = begin; k < end; ++k) {
          const int cell = of(bounded_, k), column = cell % columns, row = cell / columns;
          const int i = row * cloth.columns + column;
          const std::array<int, 4> corners{i, i + 1, i + cloth.columns, i + cloth.columns + 1};
          bounds_[static_cast<std::size_t>(cell)] = {
              around(positions, corners), gradient_bounds(cloth, positions, column, row)};
        }
      },
      least);
}

/// Those of the pairs sought that may come near before they are sought again.
void NearPairs::take_candidates(const Points& positions, Scratch& scratch) const {
  scratch.distances.measure(positions);
  for (std::size_t i = 0; i < scratch.sought.size(); ++i) {
    Candidate& candidate = scratch.sought[i].candidate;
    PatchPair& pair = *scratch.sought[i].of;
    candidate.pair.nearest = nearest_.of(candidate.pair);
    const double gap = scratch.distances[i] - candidate.pair.nearest;
    if (gap > margin_ + pair.allowance) continue;
    pair.candidates.push_back(candidate);
    pair.wake_at.push_back(gap);
    pair.least_wake = std::min(pair.least_wake, gap);
    pair.least_nearest = std::min(pair.least_nearest, candidate.pair.nearest);
  }
  scratch.sought.clear();
  scratch.distances.clear();
}

/// Pairs the patches whose boxes are within `reach`; those that were paired before go on.
void NearPairs::pair_patches(const Points& positions, double reach) {
  std::vector<Box> boxes;
  for (const Patch& patch : patches_) {
    boxes.push_back(around(positions, patch.points));
    boxes.back().min().array() -= reach / 2;
    boxes.back().max().array() += reach / 2;
  }
  std::vector<PatchPair> pairs;
  const auto add = [&](int p, int q) { pairs.push_back({p, q, infinity, 0, true, 0, 0, {}, {}}); };
  for (int p = 0; p < static_cast<int>(patches_.size()); ++p) add(p, p);
  BoxTree(boxes).visit_overlaps(add);
  const auto before = [](const PatchPair& a, const PatchPair& b) {
    return a.p < b.p || (a.p == b.p && a.q < b.q);
  };
  std::sort(pairs.begin(), pairs.end(), before);

  auto last = patch_pairs_.begin();
  for (PatchPair& pair : pairs) {
    while (last != patch_pairs_.end() && before(*last, pair)) ++last;
    if (last != patch_pairs_.end() && last->p == pair.p && last->q == pair.q) {
      pair = std::move(*last);
    }
  }
  patch_pairs_ = std::move(pairs);
  paired_at_ = positions;
}

void NearPairs::seek(const Points& positions, PatchPair& pair, Scratch& scratch) const {
  const Patch &p = of(patches_, pair.p), &q = of(patches_, pair.q);
  const double range = margin_ + pair.allowance;
  const auto within_reach_of = [&](const Patch& patch, const Patch& other) {
    const Box box = around(positions, other.points);
    std::vector<std::size_t> numbers;
    for (std::size_t i = 0; i < patch.cells.size(); ++i) {
      if (overlap(of(bounds_, patch.cells[i]).box, box, contact_ + range)) numbers.push_back(i);
    }
    return numbers;
  };
  const std::vector<std::size_t> of_p = within_reach_of(p, q), of_q = within_reach_of(q, p);
  const bool neighbours = are_neighbours(pair);
  const std::uint64_t key =
      (static_cast<std::uint64_t>(pair.p) << 40) | (static_cast<std::uint64_t>(pair.q) << 16);
  for (const std::size_t i : of_p) {
    const int cell = p.cells[i];
    const Box& box = of(bounds_, cell).box;
    for (const std::size_t j : of_q) {
      if (pair.p == pair.q && j < i) continue;
      const int other = q.cells[j];
      const double within = nearest_.most_of_cells(cell, other) + range;
      if (!overlap(box, of(bounds_, other).box, within)) continue;
      if (neighbours && proved_apart(cell, other, range)) continue;
      if (scratch.distances.size() + most_of_cells > Distances::capacity) {
        take_candidates(positions, scratch);
      }
      seek_in_cells(positions, cell, other, within, pair,
                    key + most_of_cells * (i * patch_cells * patch_cells + j), scratch);
    }
  }
}

/// Are neighbours within the rectangle of both cells further apart than nearest + range?
bool NearPairs::proved_apart(int cell, int other, double range) const {
  const int columns = mesh_.cell_columns;
  const auto [first_column, last_column] = std::minmax({cell % columns, other % columns});
  const auto [first_row, last_row] = std::minmax({cell / columns, other / columns});
  constexpr int most = 4;  // cells along a side that a proof is tried for
  if (last_column - first_column >= most || last_row - first_row >= most) return false;
  GradientBounds bounds;
  for (int r = first_row; r <= last_row; ++r) {
    for (int c = first_column; c <= last_column; ++c) {
      bounds.extend(of(bounds_, r * columns + c).gradient);
    }
  }
  return is_unfolded(bounds, NearestDistances::neighbour_share + range / least_rest_distance_);
}

void NearPairs::seek_in_cells(const Points& positions, int cell, int other, double within,
                              PatchPair& pair, std::uint64_t key, Scratch& scratch) const {
  const auto add = [&](const SurfacePair& features) {
    ++key;
    if (share_a_point(features)) return;
    scratch.sought.push_back({&pair, {key, features}});
    scratch.distances.add(features);
  };

  const auto add_points = [&](int of_cell, int in_cell) {
    for (const int point : of(mesh_.cell_points, of_cell)) {
      if (!overlap(Box(row(positions, point)), of(bounds_, in_cell).box, within)) {
        key += 2;
        continue;
      }
      for (const int t : {2 * in_cell, 2 * in_cell + 1}) {
        const std::array<int, 3>& corners = of(mesh_.triangles, t);
        add({false, point, t, {point, corners[0], corners[1], corners[2]}, 0});
      }
    }
  };
  add_points(cell, other);
  if (cell != other) add_points(other, cell);

  const auto& edges = of(mesh_.cell_edges, cell);
  const auto& others = of(mesh_.cell_edges, other);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const std::array<int, 2>& ends = of(mesh_.edges, edges[i]);
    for (std::size_t j = 0; j < others.size(); ++j) {
      if (cell == other && j <= i) {
        ++key;
        continue;
      }
      const std::array<int, 2>& other_ends = of(mesh_.edges, others[j]);
      add({true, edges[i], others[j], {ends[0], ends[1], other_ends[0], other_ends[1]}, 0});
    }
  }
}

}  // namespace clothsim
