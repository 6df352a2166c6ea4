#include "clothsim/collision/near_pairs.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace clothsim {
namespace {

/// Margin and slack of neighbours, of the least distance at rest: small enough that a moderate
/// bend is proved to keep them apart.
constexpr double margin_share = 0.12;
constexpr double slack_share = 0.23;

/// Slack of others, of the contact distance.
constexpr double far_slack_share = 0.5;

/// Cells along the side of a patch, and so many of its sides more than needed paired patches may be
/// apart.
constexpr int patch_cells = 4;
constexpr double pairing_sides = 0.5;

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Most pairs of features of two cells.
constexpr std::uint64_t most_of_cells = 64;

Vector3 row(const Points& points, int i) { return {points(i, 0), points(i, 1), points(i, 2)}; }

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

NearPairs::NearPairs(const Cloth& cloth)
    : mesh_(cloth), nearest_(cloth), patches_(cut_into_patches(cloth, patch_cells)) {
  const Points& x = cloth.rest_positions;
  const double along_row = (x.row(1) - x.row(0)).norm();
  const double along_column = (x.row(cloth.columns) - x.row(0)).norm();
  spacing_ = std::min(along_row, along_column);
  // A point and the long side of a triangle; two diagonals side by side are as far apart.
  least_rest_distance_ = along_row * along_column / std::hypot(along_row, along_column);
  margin_ = margin_share * least_rest_distance_;
  bounds_.resize(static_cast<std::size_t>(mesh_.num_cells()));
}

const std::vector<NearPair>& NearPairs::approaching(const Cloth& cloth, const Points& positions,
                                                    const Points& ahead) {
  advance(cloth, positions);
  motions_.follow(patches_, positions, ahead);
  near_.clear();
  for (PatchPair& pair : patch_pairs_) {
    const double closing = motions_.between(pair.p, pair.q);
    const double most = std::clamp(closing, least_margin(), margin_);
    if (pair.least_wake - pair.moved > most) continue;
    wake(positions, pair, [most](double) { return most; });
  }
  measure_awake(positions);
  return near_;
}

const std::vector<NearPair>& NearPairs::within(const Cloth& cloth, const Points& positions,
                                               double distance) {
  assert(distance <= reach());
  advance(cloth, positions);
  near_.clear();
  for (PatchPair& pair : patch_pairs_) {
    if (pair.least_wake - pair.moved + pair.least_nearest > distance) continue;
    wake(positions, pair, [distance](double nearest) { return distance - nearest; });
  }
  measure_awake(positions);
  return near_;
}

/// Wakes the candidates whose gap may be within `reach` of their nearest distance.
template <typename Reach>
void NearPairs::wake(const Points& positions, PatchPair& pair, const Reach& reach) {
  pair.least_wake = infinity;
  for (std::size_t k = 0; k < pair.candidates.size(); ++k) {
    const SurfacePair& features = pair.candidates[k].pair;
    const double gap = reach(features.nearest);
    if (pair.wake_at[k] - pair.moved > gap) {
      pair.least_wake = std::min(pair.least_wake, pair.wake_at[k]);
      continue;
    }
    awake_.push_back({&pair, k, gap});
    distances_.add(features);
    if (distances_.size() == Distances::capacity) measure_awake(positions);
  }
}

/// Those that are as near as they were woken for. All go to sleep again.
void NearPairs::measure_awake(const Points& positions) {
  distances_.measure(positions);
  for (std::size_t i = 0; i < awake_.size(); ++i) {
    const auto& [pair, number, reach] = awake_[i];
    const Candidate& candidate = pair->candidates[number];
    double gap = distances_[i] - candidate.pair.nearest;
    if (gap <= reach) {
      const Separation s = separation(candidate.pair, positions);
      gap = s.distance - candidate.pair.nearest;
      if (gap <= reach) near_.push_back({candidate.key, candidate.pair, s});
    }
    pair->wake_at[number] = pair->moved + gap;
    pair->least_wake = std::min(pair->least_wake, pair->wake_at[number]);
  }
  awake_.clear();
  distances_.clear();
}

/// Brings patch pairs and candidates up to date.
void NearPairs::advance(const Cloth& cloth, const Points& positions) {
  const double reach = 2 * cloth.thickness + margin_;
  const double most_spread = pairing_sides * patch_cells * spacing_;
  if (last_.rows() == 0) {
    pair_patches(positions, reach + most_spread);
  } else if (last_ != positions) {
    motions_.follow(patches_, last_, positions);
    for (PatchPair& pair : patch_pairs_) pair.moved += motions_.between(pair.p, pair.q);
    Points ways = positions - paired_at_;
    const Eigen::RowVector3d common = ways.colwise().mean();
    ways.rowwise() -= common;
    const double spread = std::sqrt(ways.rowwise().squaredNorm().maxCoeff());
    if (2 * spread > most_spread) pair_patches(positions, reach + most_spread);
  } else {
    return;
  }
  last_ = positions;
  ++search_;
  for (PatchPair& pair : patch_pairs_) {
    if (pair.moved >= pair.allowance) seek(cloth, positions, pair);
  }
  take_candidates(positions);
}

/// Those of the pairs sought that may come near before they are sought again.
void NearPairs::take_candidates(const Points& positions) {
  distances_.measure(positions);
  for (std::size_t i = 0; i < sought_.size(); ++i) {
    Candidate& candidate = sought_[i].candidate;
    PatchPair& pair = *sought_[i].of;
    candidate.pair.nearest = nearest_.of(candidate.pair);
    const double gap = distances_[i] - candidate.pair.nearest;
    if (gap > margin_ + pair.allowance) continue;
    pair.candidates.push_back(candidate);
    pair.wake_at.push_back(gap);
    pair.least_wake = std::min(pair.least_wake, gap);
    pair.least_nearest = std::min(pair.least_nearest, candidate.pair.nearest);
  }
  sought_.clear();
  distances_.clear();
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
  const auto add = [&](int p, int q) { pairs.push_back({p, q, infinity, 0, 0, 0, {}, {}}); };
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

void NearPairs::seek(const Cloth& cloth, const Points& positions, PatchPair& pair) {
  pair.candidates.clear();
  pair.wake_at.clear();
  pair.moved = 0;
  pair.least_wake = infinity;
  pair.least_nearest = infinity;

  // Patches far from each other.
  const Patch &p = of(patches_, pair.p), &q = of(patches_, pair.q);
  const double reach = 2 * cloth.thickness + margin_;
  const double apart =
      std::sqrt(around(positions, p.points).squaredExteriorDistance(around(positions, q.points)));
  const double far_slack =
      std::max(slack_share * least_rest_distance_, far_slack_share * 2 * cloth.thickness);
  if (apart > reach + far_slack) {
    pair.allowance = apart - reach;
    return;
  }

  // Neighbours on the cloth have less to spare. Parts of them that are not folded are apart.
  const int columns = mesh_.cell_columns;
  const int window = static_cast<int>(std::ceil(reach / spacing_));
  const auto gap = [&](int a_first, int a_last, int b_first, int b_last) {
    return std::max(b_first - a_last, a_first - b_last);
  };
  const int column_gap = gap(p.cells.front() % columns, p.cells.back() % columns,
                             q.cells.front() % columns, q.cells.back() % columns);
  const int row_gap = gap(p.cells.front() / columns, p.cells.back() / columns,
                          q.cells.front() / columns, q.cells.back() / columns);
  const bool neighbours = column_gap <= window && row_gap <= window;
  pair.allowance = neighbours ? slack_share * least_rest_distance_ : far_slack;
  const double range = margin_ + pair.allowance;

  const auto within_reach_of = [&](const Patch& patch, const Patch& other) {
    const Box box = around(positions, other.points);
    std::vector<std::size_t> numbers;
    for (std::size_t i = 0; i < patch.cells.size(); ++i) {
      const Box& cell = bound(cloth, positions, patch.cells[i]).box;
      if (overlap(cell, box, 2 * cloth.thickness + range)) numbers.push_back(i);
    }
    return numbers;
  };
  const std::vector<std::size_t> of_p = within_reach_of(p, q), of_q = within_reach_of(q, p);
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
      if (neighbours && proved_apart(cloth, positions, cell, other, range)) continue;
      if (distances_.size() + most_of_cells > Distances::capacity) take_candidates(positions);
      seek_in_cells(positions, cell, other, within, pair,
                    key + most_of_cells * (i * patch_cells * patch_cells + j));
    }
  }
}

/// Box and gradient of a cell, once for each search.
const NearPairs::CellBounds& NearPairs::bound(const Cloth& cloth, const Points& positions,
                                              int cell) {
  CellBounds& bounds = bounds_[static_cast<std::size_t>(cell)];
  if (bounds.search == search_) return bounds;
  const int column = cell % mesh_.cell_columns, r = cell / mesh_.cell_columns;
  const int i = r * cloth.columns + column;
  const std::array<int, 4> corners{i, i + 1, i + cloth.columns, i + cloth.columns + 1};
  bounds = {search_, around(positions, corners), gradient_bounds(cloth, positions, column, r)};
  return bounds;
}

/// Are neighbours within the rectangle of both cells further apart than nearest + range?
bool NearPairs::proved_apart(const Cloth& cloth, const Points& positions, int cell, int other,
                             double range) {
  const int columns = mesh_.cell_columns;
  const auto [first_column, last_column] = std::minmax({cell % columns, other % columns});
  const auto [first_row, last_row] = std::minmax({cell / columns, other / columns});
  constexpr int most = 4;  // cells along a side that a proof is tried for
  if (last_column - first_column >= most || last_row - first_row >= most) return false;
  GradientBounds bounds;
  for (int r = first_row; r <= last_row; ++r) {
    for (int c = first_column; c <= last_column; ++c) {
      bounds.extend(bound(cloth, positions, r * columns + c).gradient);
    }
  }
  return is_unfolded(bounds, NearestDistances::neighbour_share + range / least_rest_distance_);
}

void NearPairs::seek_in_cells(const Points& positions, int cell, int other, double within,
                              PatchPair& pair, std::uint64_t key) {
  const auto add = [&](const SurfacePair& features) {
    ++key;
    if (share_a_point(features)) return;
    sought_.push_back({&pair, {key, features}});
    distances_.add(features);
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
