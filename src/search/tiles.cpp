#include "clothsim/search/tiles.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

constexpr std::size_t num_tiles = TileShapes::tiles;

using Row = TileShapes::Row;

/// Marks the `distances` within `gap` of their `nearest` or within `min_range`; updates the least
/// of the others, and of their difference from nearest. Returns whether any is marked.
CLOTHSIM_TARGET_CLONES
bool sort_out(const Row& distances, const float* __restrict nearest, float gap, float min_range,
              std::array<int, num_tiles>& near, Row& rest, Row& rest_gap) {
  int any = 0;
#pragma GCC ivdep
  for (std::size_t j = 0; j < num_tiles; ++j) {
    const float distance = distances[j];
    const int is_near = distance > larger(nearest[j] + gap, min_range) ? 0 : 1;
    near[j] = is_near;
    any |= is_near;
    rest[j] = is_near != 0 ? rest[j] : smaller(rest[j], distance);
    rest_gap[j] = is_near != 0 ? rest_gap[j] : smaller(rest_gap[j], distance - nearest[j]);
  }
  return any != 0;
}

using Numbers = std::array<int, num_tiles>;

/// Takes the corners of tiles by number: with a loop over them a fold takes 4 % longer.
CLOTHSIM_TARGET_CLONES
void pick(const TileShapes::Corners& from, const Numbers& numbers, TileShapes::Corners& to) {
  for (std::size_t corner = 0; corner < Tiling::corners; ++corner) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Row& row = from[corner][axis];
      Row& picked = to[corner][axis];
#ifdef __clang__  // its shuffles need constants
      for (std::size_t k = 0; k < num_tiles; ++k)
        picked[k] = row[static_cast<std::size_t>(numbers[k])];
#else
      using Floats =
          float __attribute__((vector_size(num_tiles * sizeof(float)), aligned(4), may_alias));
      using Ints = int __attribute__((vector_size(num_tiles * sizeof(int)), aligned(4), may_alias));
      *reinterpret_cast<Floats*>(picked.data()) =
          __builtin_shuffle(*reinterpret_cast<const Floats*>(row.data()),
                            *reinterpret_cast<const Ints*>(numbers.data()));
#endif
    }
  }
}

}  // namespace

TileShapes::TileShapes(std::shared_ptr<const Tiling> tiling,
                       std::shared_ptr<const std::vector<Patch>> patches)
    : tiling_(std::move(tiling)),
      patches_(std::move(patches)),
      corners_(patches_->size()),
      roundings_(patches_->size()) {}

void TileShapes::update(int patch, const Points& positions) {
  const auto& tiles_of = (*patches_)[static_cast<std::size_t>(patch)].tiles;
  float farthest = 0;
  for (std::size_t k = 0; k < num_tiles; ++k) {
    const auto& points = tiling_->at(tiles_of[exists(patch, k) ? k : 0]).points;
    for (std::size_t corner = 0; corner < Tiling::corners; ++corner) {
      const int point = points[corner];
      const Vector3 seen = row(positions, point) - row(positions, 0);  // preserves digits
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto at = static_cast<float>(seen[static_cast<Eigen::Index>(axis)]);
        corners_[static_cast<std::size_t>(patch)][corner][axis][k] = at;
        farthest = std::max(farthest, std::abs(at));
      }
    }
  }
  roundings_[static_cast<std::size_t>(patch)] =
      4 * std::numeric_limits<float>::epsilon() * farthest;
}

float TileShapes::rounding(int patch, int other) const {
  return std::max(roundings_[static_cast<std::size_t>(patch)],
                  roundings_[static_cast<std::size_t>(other)]);
}

/// `measure`: computes the distances from a tile to all of the other patch.
template <typename Measure>
void TileShapes::sort_out_near(int patch, int other, const PairValues& nearest, float gap,
                               float min_range, const Measure& measure, Near& near) const {
  std::array<int, num_tiles> is_near;
  Row distances, rest, rest_gap;
  rest.fill(infinity);
  rest_gap.fill(infinity);
  near.count = 0;
  for (std::size_t i = 0; i < num_tiles; ++i) {
    if (!exists(patch, i)) continue;
    measure(i, distances);
    if (!sort_out(distances, nearest.data() + i * num_tiles, gap, min_range, is_near, rest,
                  rest_gap)) {
      continue;
    }
    for (std::size_t j = patch == other ? i + 1 : 0; j < num_tiles; ++j) {
      near.pairs[near.count] = static_cast<int>(i * num_tiles + j);
      near.count += is_near[j] != 0 && exists(other, j) ? 1 : 0;
    }
  }
  near.rest = *std::min_element(rest.begin(), rest.end());
  near.rest_gap = *std::min_element(rest_gap.begin(), rest_gap.end());
}

void TileShapes::look(int patch, int other, const PairValues& nearest, float gap, float min_range,
                      Near& near) const {
  const Corners &a = corners_[static_cast<std::size_t>(patch)],
                &b = corners_[static_cast<std::size_t>(other)];
  sort_out_near(
      patch, other, nearest, gap, min_range,
      [&](std::size_t i, Row& distances) { DistanceRows::hull_hull(a, i, b, distances); }, near);
}

void TileShapes::look_at_points(int patch, int other, const PairValues& nearest, float gap,
                                Near& near) const {
  const Corners &a = corners_[static_cast<std::size_t>(patch)],
                &b = corners_[static_cast<std::size_t>(other)];
  sort_out_near(
      patch, other, nearest, gap, -1,
      [&](std::size_t i, Row& distances) { DistanceRows::point_point(a[0], i, b[0], distances); },
      near);
}

void TileShapes::measure(int patch, int other, const int* pairs, std::size_t count,
                         Distances& found) const {
  Numbers first, second;
  for (std::size_t k = 0; k < num_tiles; ++k) {
    const int pair = pairs[std::min(k, count - 1)];
    first[k] = pair / static_cast<int>(num_tiles);
    second[k] = pair % static_cast<int>(num_tiles);
  }
  std::array<Corners, 2> of;
  pick(corners_[static_cast<std::size_t>(patch)], first, of[0]);
  pick(corners_[static_cast<std::size_t>(other)], second, of[1]);
  for (std::size_t k = 0; k < Tiling::points; ++k) {
    const Corners &point = of[k / 2], &other_tile = of[1 - k / 2];
    const auto& [a, b, c] = Tiling::triangles[k % 2];
    DistanceRows::point_triangle(point[0], other_tile[a], other_tile[b], other_tile[c],
                                 found.values[k], found.within[k]);
  }
  for (std::size_t k = Tiling::points; k < Tiling::own_points; ++k) {
    const auto& [a, b] = Tiling::edges[(k - Tiling::points) / 3];
    const auto& [c, d] = Tiling::edges[(k - Tiling::points) % 3];
    DistanceRows::edge_edge(of[0][a], of[0][b], of[1][c], of[1][d], found.values[k]);
  }
}

}  // namespace clothsim
