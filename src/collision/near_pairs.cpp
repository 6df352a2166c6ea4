#include "clothsim/collision/near_pairs.h"

#include <algorithm>
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

/// Most pairs of features of two cells.
constexpr std::uint64_t most_of_cells = 64;

Vector3 row(const Points& points, int i) { return {points(i, 0), points(i, 1), points(i, 2)}; }

template <std::size_t count>
Box around(const Points& positions, const std::array<int, count>& points) {
  Box box(row(positions, points[0]));
  for (std::size_t i = 1; i < count; ++i) box.extend(row(positions, points[i]));
  return box;
}

/// Are two boxes within a distance of each other along each axis?
bool overlap(const Box& p, const Box& q, double within) {
  return ((p.min() - q.max()).array() <= within).all() &&
         ((q.min() - p.max()).array() <= within).all();
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

NearPairs::NearPairs(const Cloth& cloth) : mesh_(cloth), nearest_(cloth) {
  const Points& x = cloth.rest_positions;
  const double along_row = (x.row(1) - x.row(0)).norm();
  const double along_column = (x.row(cloth.columns) - x.row(0)).norm();
  spacing_ = std::min(along_row, along_column);
  // A point and the long side of a triangle; two diagonals side by side are as far apart.
  least_rest_distance_ = along_row * along_column / std::hypot(along_row, along_column);
  margin_ = margin_share * least_rest_distance_;
  cut_into_patches(cloth);
}

void NearPairs::cut_into_patches(const Cloth& cloth) {
  for (int row = 0; row < mesh_.cell_rows; row += patch_cells) {
    for (int column = 0; column < mesh_.cell_columns; column += patch_cells) {
      const int end_row = std::min(row + patch_cells, mesh_.cell_rows);
      const int end_column = std::min(column + patch_cells, mesh_.cell_columns);
      Patch patch;
      for (int r = row; r <= end_row; ++r) {
        for (int c = column; c <= end_column; ++c) {
          patch.points.push_back(r * cloth.columns + c);
          if (r < end_row && c < end_column) patch.cells.push_back(r * mesh_.cell_columns + c);
        }
      }
      patches_.push_back(std::move(patch));
    }
  }
}

const std::vector<NearPair>& NearPairs::measure(const Cloth& cloth, const Points& positions) {
  follow(positions);
  bool bounded = false;
  const double reach = 2 * cloth.thickness + margin_;
  const double most_spread = pairing_sides * patch_cells * spacing_;
  if (patch_pairs_.empty() || 2 * spread_ > most_spread) {
    bound(cloth, positions);
    bounded = true;
    pair_patches(reach + most_spread);
  }

  near_.clear();
  for (PatchPair& pair : patch_pairs_) {
    const Patch &p = of(patches_, pair.p), &q = of(patches_, pair.q);
    pair.moved += (p.way - q.way).norm() + p.deviation + q.deviation;
    if (pair.moved >= pair.allowance) {
      if (!bounded) bound(cloth, positions);
      bounded = true;
      seek(cloth, positions, pair);
    }
    for (std::size_t k = 0; k < pair.candidates.size(); ++k) {
      if (pair.wake_at[k] > pair.moved) continue;
      Candidate& candidate = pair.candidates[k];
      const double near = candidate.pair.nearest + margin_;
      double distance = gap_along(candidate.direction, candidate.pair, positions);
      if (distance <= near) {
        const Separation s = separation(candidate.pair, positions);
        distance = s.distance;
        candidate.direction = s.normal;
        if (distance <= near) near_.push_back({candidate.key, candidate.pair, s});
      }
      pair.wake_at[k] = pair.moved + distance - near;
    }
  }
  return near_;
}

/// How patches have moved, and all points beyond the cloth's common way.
void NearPairs::follow(const Points& positions) {
  if (last_.rows() == 0) {
    last_ = positions;
    return;
  }
  const Points ways = positions - last_;
  last_ = positions;
  const Eigen::RowVector3d common = ways.colwise().mean();
  spread_ += std::sqrt((ways.rowwise() - common).rowwise().squaredNorm().maxCoeff());
  for (Patch& patch : patches_) {
    patch.way.setZero();
    for (const int i : patch.points) patch.way += row(ways, i);
    patch.way /= static_cast<double>(patch.points.size());
    double farthest2 = 0;
    for (const int i : patch.points) {
      farthest2 = std::max(farthest2, (row(ways, i) - patch.way).squaredNorm());
    }
    patch.deviation = std::sqrt(farthest2);
  }
}

/// Boxes and gradients at `positions`.
void NearPairs::bound(const Cloth& cloth, const Points& positions) {
  const int columns = mesh_.cell_columns;
  cell_boxes_.clear();
  gradients_.clear();
  for (int cell = 0; cell < mesh_.num_cells(); ++cell) {
    const int i = cell / columns * cloth.columns + cell % columns;
    const std::array<int, 4> corners{i, i + 1, i + cloth.columns, i + cloth.columns + 1};
    cell_boxes_.push_back(around(positions, corners));
    gradients_.push_back(gradient_bounds(cloth, positions, cell % columns, cell / columns));
  }
  patch_boxes_.clear();
  for (const Patch& patch : patches_) {
    Box box;
    for (const int cell : patch.cells) box.extend(of(cell_boxes_, cell));
    patch_boxes_.push_back(box);
  }
}

/// Pairs the patches whose boxes are within `reach`; those that were paired before go on.
void NearPairs::pair_patches(double reach) {
  std::vector<Box> boxes = patch_boxes_;
  for (Box& box : boxes) {
    box.min().array() -= reach / 2;
    box.max().array() += reach / 2;
  }
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::vector<PatchPair> pairs;
  for (int p = 0; p < static_cast<int>(patches_.size()); ++p) {
    pairs.push_back({p, p, infinity, 0, {}, {}});
  }
  BoxTree(boxes).visit_overlaps([&](int p, int q) {
    pairs.push_back({p, q, infinity, 0, {}, {}});
  });
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
  spread_ = 0;
}

void NearPairs::seek(const Cloth& cloth, const Points& positions, PatchPair& pair) const {
  pair.candidates.clear();
  pair.wake_at.clear();
  pair.moved = 0;

  // Patches far from each other.
  const double reach = 2 * cloth.thickness + margin_;
  const double apart =
      std::sqrt(of(patch_boxes_, pair.p).squaredExteriorDistance(of(patch_boxes_, pair.q)));
  const double far_slack =
      std::max(slack_share * least_rest_distance_, far_slack_share * 2 * cloth.thickness);
  if (apart > reach + far_slack) {
    pair.allowance = apart - reach;
    return;
  }

  // Neighbours on the cloth have less to spare.
  const std::vector<int>& cells = of(patches_, pair.p).cells;
  const std::vector<int>& others = of(patches_, pair.q).cells;
  const int columns = mesh_.cell_columns;
  const int window = static_cast<int>(std::ceil(reach / spacing_));
  const auto gap = [&](int a_first, int a_last, int b_first, int b_last) {
    return std::max(b_first - a_last, a_first - b_last);
  };
  const int column_gap = gap(cells.front() % columns, cells.back() % columns,
                             others.front() % columns, others.back() % columns);
  const int row_gap = gap(cells.front() / columns, cells.back() / columns, others.front() / columns,
                          others.back() / columns);
  const bool neighbours = column_gap <= window && row_gap <= window;
  pair.allowance = neighbours ? slack_share * least_rest_distance_ : far_slack;
  const double range = margin_ + pair.allowance;

  std::uint64_t key =
      (static_cast<std::uint64_t>(pair.p) << 40) | (static_cast<std::uint64_t>(pair.q) << 16);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Box& box = of(cell_boxes_, cells[i]);
    for (std::size_t j = pair.p == pair.q ? i : 0; j < others.size(); ++j) {
      const double within = nearest_.most_of_cells(cells[i], others[j]) + range;
      if (!overlap(box, of(cell_boxes_, others[j]), within)) continue;
      if (neighbours && proved_apart(cells[i], others[j], range)) continue;
      seek_in_cells(positions, cells[i], others[j], range,
                    key + most_of_cells * (i * patch_cells * patch_cells + j), pair.candidates);
    }
  }
  pair.wake_at.assign(pair.candidates.size(), 0.0);
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
    for (int c = first_column; c <= last_column; ++c)
      bounds.extend(of(gradients_, r * columns + c));
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
      if (!overlap(box, of(cell_boxes_, in_cell), within_cells)) {
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
    if (!overlap(box, of(cell_boxes_, other), within_cells)) {
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
