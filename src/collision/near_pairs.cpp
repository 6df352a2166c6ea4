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
    collect(positions, pair, [most](double) { return most; });
  }
  return near_;
}

const std::vector<NearPair>& NearPairs::within(const Cloth& cloth, const Points& positions,
                                               double distance) {
  assert(distance <= reach());
  advance(cloth, positions);
  near_.clear();
  for (PatchPair& pair : patch_pairs_) {
    if (pair.least_wake - pair.moved + pair.least_nearest > distance) continue;
    collect(positions, pair, [distance](double nearest) { return distance - nearest; });
  }
  return near_;
}

/// Measures what may be within `reach`, of its nearest distance, beyond that.
template <typename Reach>
void NearPairs::collect(const Points& positions, PatchPair& pair, const Reach& reach) {
  pair.least_wake = infinity;
  for (std::size_t k = 0; k < pair.candidates.size(); ++k) {
    Candidate& candidate = pair.candidates[k];
    const double nearest = candidate.pair.nearest;
    const double most = reach(nearest);
    if (pair.wake_at[k] - pair.moved <= most) {
      double left = gap_along(candidate.direction, candidate.pair, positions) - nearest;
      if (left <= most) {
        const Separation s = separation(candidate.pair, positions);
        candidate.direction = s.normal;
        left = s.distance - nearest;
        if (left <= most) near_.push_back({candidate.key, candidate.pair, s});
      }
      pair.wake_at[k] = pair.moved + left;
    }
    pair.least_wake = std::min(pair.least_wake, pair.wake_at[k]);
  }
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

  for (const int cell : p.cells) bound(cloth, positions, cell);
  for (const int cell : q.cells) bound(cloth, positions, cell);
  std::uint64_t key =
      (static_cast<std::uint64_t>(pair.p) << 40) | (static_cast<std::uint64_t>(pair.q) << 16);
  for (std::size_t i = 0; i < p.cells.size(); ++i) {
    const Box& box = of(bounds_, p.cells[i]).box;
    for (std::size_t j = pair.p == pair.q ? i : 0; j < q.cells.size(); ++j) {
      const double within = nearest_.most_of_cells(p.cells[i], q.cells[j]) + range;
      if (!overlap(box, of(bounds_, q.cells[j]).box, within)) continue;
      if (neighbours && proved_apart(cloth, positions, p.cells[i], q.cells[j], range)) continue;
      seek_in_cells(positions, p.cells[i], q.cells[j], range,
                    key + most_of_cells * (i * patch_cells * patch_cells + j), pair.candidates);
    }
  }
  pair.wake_at.assign(pair.candidates.size(), 0.0);
  for (const Candidate& candidate : pair.candidates) {
    pair.least_wake = 0;
    pair.least_nearest = std::min(pair.least_nearest, candidate.pair.nearest);
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

void NearPairs::seek_in_cells(const Points& positions, int cell, int other, double range,
                              std::uint64_t key, std::vector<Candidate>& candidates) const {
  const double within_cells = nearest_.most_of_cells(cell, other) + range;
  const auto consider = [&](SurfacePair pair, const Box& a, const Box& b) {
    ++key;
    if (share_a_point(pair)) return;
    pair.nearest = nearest_.of(pair);
    const double within = pair.nearest + range;
    if (!overlap(a, b, within)) return;
    const Separation s = separation(pair, positions);
    if (s.distance < within) candidates.push_back({key, pair, s.normal});
  };

  const auto consider_points = [&](int of_cell, int in_cell) {
    for (const int point : of(mesh_.cell_points, of_cell)) {
      const Box box(row(positions, point));
      if (!overlap(box, of(bounds_, in_cell).box, within_cells)) {
        key += 2;
        continue;
      }
      for (const int t : {2 * in_cell, 2 * in_cell + 1}) {
        const std::array<int, 3>& corners = of(mesh_.triangles, t);
        consider({false, point, t, {point, corners[0], corners[1], corners[2]}, 0}, box,
                 around(positions, corners));
      }
    }
  };
  consider_points(cell, other);
  if (cell != other) consider_points(other, cell);

  const std::vector<int>& edges = of(mesh_.cell_edges, cell);
  const std::vector<int>& others = of(mesh_.cell_edges, other);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const std::array<int, 2>& ends = of(mesh_.edges, edges[i]);
    const Box box = around(positions, ends);
    if (!overlap(box, of(bounds_, other).box, within_cells)) {
      key += others.size();
      continue;
    }
    for (std::size_t j = 0; j < others.size(); ++j) {
      const std::array<int, 2>& other_ends = of(mesh_.edges, others[j]);
      if (cell == other && j <= i) {
        ++key;
        continue;
      }
      consider({true, edges[i], others[j], {ends[0], ends[1], other_ends[0], other_ends[1]}, 0},
               box, around(positions, other_ends));
    }
  }
}

}  // namespace clothsim
