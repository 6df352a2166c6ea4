// Features of two patches that are near each other: near_pairs.cpp decides when they are measured.

#include <algorithm>

#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"
#include "clothsim/search/near_pairs.h"

namespace clothsim {
namespace {

using Row = TileShapes::Row;
constexpr std::size_t lanes = TileShapes::tiles;
constexpr auto range = static_cast<float>(TrackedPairs::range);

/// Points are tracked up to this share of a triangle beside it: farther outside another one is
/// nearer.
constexpr float outside_tolerance = 0.1F;

/// Range in which edges of layers with near points are listed, of their contact distance: a quarter
/// of that of tracked pairs.
constexpr float edge_range = 1 + (range - 1) / 4;

/// Results for the distances of sixteen pairs of tiles.
struct Judged {
  Row to_touch;
  Row to_meet;
  std::array<int, lanes> near;  // features, a bit for each
  std::array<int, lanes> meet;
};

/// `nearest`: contact distances, below 0 for missing features. `within`: distance for `meet`.
CLOTHSIM_TARGET_CLONES
void judge(const TileShapes::Features& distances, const TileShapes::Features& nearest,
           float rounding, float within, Judged& judged) {
  Row to_touch, to_meet, ranges, min_gap;
  to_touch.fill(TileShapes::infinity);
  to_meet.fill(TileShapes::infinity);
  ranges.fill(range);
  min_gap.fill(-TileShapes::infinity);
  std::array<int, lanes> near{}, meet{};
  for (std::size_t k = 0; k < Tiling::own_points; ++k) {
    // Where points are near a layer, their contacts keep it off before edges touch.
    for (std::size_t i = 0; k == Tiling::points && i < lanes; ++i) {
      ranges[i] = near[i] != 0 ? edge_range : range;
      min_gap[i] = near[i] != 0 ? TileShapes::infinity : -TileShapes::infinity;
    }
    const int bit = 1 << k;
    for (std::size_t i = 0; i < lanes; ++i) {
      const float may = nearest[k][i];
      const float distance = may < 0 ? TileShapes::infinity : distances[k][i] - rounding;
      const bool is_near = distance < ranges[i] * may;
      const float gap = is_near ? (range - 1) * may : distance - may;
      to_meet[i] = smaller(to_meet[i], distance);
      to_touch[i] = smaller(to_touch[i], larger(gap, min_gap[i]));
      near[i] = is_near ? near[i] | bit : near[i];
      meet[i] = distance <= within ? meet[i] | bit : meet[i];
    }
  }
  judged = {to_touch, to_meet, near, meet};
}

}  // namespace

std::pair<int, int> NearPairs::tiles(const PatchPair& pair, int number) const {
  const auto tile = static_cast<std::size_t>(number);
  return {(*patches_)[static_cast<std::size_t>(pair.p)].tiles[tile / lanes],
          (*patches_)[static_cast<std::size_t>(pair.q)].tiles[tile % lanes]};
}

/// Finds features that are not tracked yet, edges that are near, and features within a distance
/// [m].
void NearPairs::measure(PatchPair& pair, double within, Found& found) const {
  pair.listed.clear();
  const float rounding = shapes_.rounding(pair.p, pair.q);
  const auto gap = static_cast<float>((TrackedPairs::range - 1) * nearest_->max());
  TileShapes::Near near;
  shapes_.look(pair.p, pair.q, nearest_->of_patches(pair.p, pair.q).max, gap,
               static_cast<float>(std::max(within, 0.0)) + rounding, near);
  pair.to_meet = std::min<double>(near.rest, paired_) - rounding;
  pair.to_touch = std::min<double>(near.rest_gap, paired_) - rounding;
  for (std::size_t first = 0; first < near.count; first += lanes) {
    const std::size_t count = std::min(near.count - first, lanes);
    measure_batch(pair, near.pairs.data() + first, count, within, found);
  }
}

/// Lists the points that are near, or may be on the paths of the last query.
void NearPairs::measure_points(PatchPair& pair) const {
  pair.listed.clear();
  const float rounding = shapes_.rounding(pair.p, pair.q);
  const auto gap = static_cast<float>((TrackedPairs::range - 1) * nearest_->max() + pair.step);
  TileShapes::Near near;
  shapes_.look_at_points(pair.p, pair.q, nearest_->of_patches(pair.p, pair.q).max, gap + rounding,
                         near);
  pair.to_meet = std::min<double>(near.rest, paired_) - rounding;
  pair.to_touch = std::min<double>(near.rest_gap, paired_) - rounding;
  for (std::size_t k = 0; k < near.count; ++k) {
    const auto& [a, b] = tiles(pair, near.pairs[k]);
    if (nearest_->of(a, b, Tiling::own_points) < 0) continue;  // neighbours, or not its own
    pair.listed.push_back({a, b, static_cast<int>(Tiling::own_points), 0});
  }
}

/// For up to sixteen pairs of tiles.
void NearPairs::measure_batch(PatchPair& pair, const int* pairs, std::size_t count, double within,
                              Found& found) const {
  const NearestDistances::OfPatches& of_patches = nearest_->of_patches(pair.p, pair.q);
  TileShapes::Features may;
  for (std::size_t i = 0; i < lanes; ++i) {
    const int number = pairs[std::min(i, count - 1)];
    const auto& [a, b] = tiles(pair, number);
    const NearestDistances::OfTiles of_tiles = nearest_->of_tiles(of_patches, number, a, b);
    for (std::size_t k = 0; k < Tiling::own_points; ++k) may[k][i] = of_tiles[k];
  }
  TileShapes::Distances distances;
  shapes_.measure(pair.p, pair.q, pairs, count, distances);
  Judged judged;
  judge(distances.values, may, shapes_.rounding(pair.p, pair.q), static_cast<float>(within),
        judged);
  for (std::size_t i = 0; i < count; ++i) {
    pair.to_meet = std::min<double>(pair.to_meet, judged.to_meet[i]);
    pair.to_touch = std::min<double>(pair.to_touch, judged.to_touch[i]);
    const auto& [a, b] = tiles(pair, pairs[i]);
    for (int left = judged.near[i] | judged.meet[i]; left != 0; left &= left - 1) {
      const auto k = static_cast<std::size_t>(__builtin_ctz(static_cast<unsigned>(left)));
      const bool is_near = (judged.near[i] >> k & 1) != 0,
                 is_within = (judged.meet[i] >> k & 1) != 0;
      const float distance = distances.values[k][i], nearest = may[k][i];
      if (is_near && k >= Tiling::points) {
        pair.listed.push_back({a, b, static_cast<int>(k), distance - nearest});
      }
      // Beside a triangle another one is nearer, except beyond the border.
      const bool may_be_tracked =
          is_near && k < Tiling::points &&
          (distances.within[k][i] > -outside_tolerance || distance < nearest ||
           nearest_->at_border(a) || nearest_->at_border(b));
      if (!may_be_tracked && !is_within) continue;
      SurfacePair both = tiling_->pair(a, b, k);
      both.nearest = nearest_->of(a, b, k);
      if (may_be_tracked && !tracked_.covers(both, distance)) found.to_track.push_back(both);
      if (is_within) {
        const Separation s = separation(both, last_);
        if (s.distance <= within) found.meet.push_back({Tiling::key(a, b, k), both, s});
      }
    }
  }
}

}  // namespace clothsim
