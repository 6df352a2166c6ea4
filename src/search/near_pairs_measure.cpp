// What two patches have near each other: near_pairs.cpp says when they are measured.

#include <algorithm>
#include <utility>

#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"
#include "near_pairs_impl.h"

namespace clothsim {
namespace {

using Row = TileShapes::Row;
constexpr std::size_t lanes = TileShapes::tiles;
constexpr float infinity = TileShapes::infinity;
constexpr auto reach = static_cast<float>(SurfaceSlots::reach);

/// Slots are proposed up to this share of a triangle beside it: further out another one is nearer.
constexpr float beside = 0.1F;

/// Edges of layers that points see are listed up to this, of the nearest that they may come: a
/// quarter as far as slots reach.
constexpr float edge_reach = 1 + (reach - 1) / 4;

/// What distances of sixteen pairs of tiles come to.
struct Judged {
  Row to_touch;
  Row to_meet;
  std::array<int, lanes> near;  // features, a bit for each
  std::array<int, lanes> meet;
};

/// `nearest`: that features may come, below 0 where there are none. `within`: what may meet.
CLOTHSIM_TARGET_CLONES
void judge(const TileShapes::Features& distances, const TileShapes::Features& nearest,
           float rounding, float within, Judged& judged) {
  Row to_touch, to_meet, reaches, least_gap, seen;
  to_touch.fill(infinity);
  to_meet.fill(infinity);
  reaches.fill(reach);
  least_gap.fill(-infinity);
  seen.fill(0);
  std::array<int, lanes> near{}, meet{};
  for (std::size_t k = 0; k < TileFeatures::count; ++k) {
    // Where points see a layer, they keep it off before edges touch.
    for (std::size_t i = 0; k == TileFeatures::points && i < lanes; ++i) {
      reaches[i] = seen[i] > 0 ? edge_reach : reach;
      least_gap[i] = seen[i] > 0 ? infinity : -infinity;
    }
    const int bit = 1 << k;
    for (std::size_t i = 0; i < lanes; ++i) {
      const float may = nearest[k][i];
      const float distance = may < 0 ? infinity : distances[k][i] - rounding;
      const bool is_near = distance < reaches[i] * may;
      const float gap = is_near ? (reach - 1) * may : distance - may;
      to_meet[i] = smaller(to_meet[i], distance);
      to_touch[i] = smaller(to_touch[i], larger(gap, least_gap[i]));
      seen[i] = is_near ? 1.0F : seen[i];
      near[i] = is_near ? near[i] | bit : near[i];
      meet[i] = distance <= within ? meet[i] | bit : meet[i];
    }
  }
  judged = {to_touch, to_meet, near, meet};
}

}  // namespace

std::uint64_t key_of(const SurfacePair& pair, int a, int b, std::size_t number) {
  if (!pair.edges()) {
    return static_cast<std::uint64_t>(pair.points[0]) << 32 |
           static_cast<std::uint64_t>(pair.triangle);
  }
  // Numbers of their edges: three of each tile.
  number -= TileFeatures::points;
  const auto edge_a = 3 * static_cast<std::uint64_t>(a) + number / 3;
  const auto edge_b = 3 * static_cast<std::uint64_t>(b) + number % 3;
  return std::uint64_t{1} << 63 | edge_a << 31 | edge_b;
}

/// Finds what has no slot yet, which edges are near, and what is within a distance [m].
void NearPairs::Impl::measure(PatchPair& pair, double within, Found& found) const {
  pair.edges.clear();
  const float rounding = shapes.rounding(pair.p, pair.q);
  const auto gap = static_cast<float>((SurfaceSlots::reach - 1) * nearest->most());
  const auto& of_p = (*patches)[static_cast<std::size_t>(pair.p)].tiles;
  const auto& of_q = (*patches)[static_cast<std::size_t>(pair.q)].tiles;
  TileShapes::Near tiles;
  shapes.look(pair.p, pair.q, nearest->of_patches(of_p[0], of_q[0]), gap,
              static_cast<float>(std::max(within, 0.0)) + rounding, tiles);
  pair.to_meet = std::min<double>(tiles.rest, paired) - rounding;
  pair.to_touch = std::min<double>(tiles.rest_gap, paired) - rounding;
  for (std::size_t first = 0; first < tiles.count; first += lanes) {
    const std::size_t count = std::min(tiles.count - first, lanes);
    measure_batch(pair, tiles.pairs.data() + first, count, within, found);
  }
}

/// A slot, where none is that keeps these apart.
void NearPairs::Impl::propose(const SurfacePair& pair, float distance, float may,
                              Found& found) const {
  const SurfaceSlots::Proposal proposal{pair.points[0], pair.triangle};
  if (!slots.covers(proposal, distance, may)) found.proposals.push_back(proposal);
}

/// Of up to sixteen pairs of tiles.
void NearPairs::Impl::measure_batch(PatchPair& pair, const int* pairs, std::size_t count,
                                    double within, Found& found) const {
  const auto& of_p = (*patches)[static_cast<std::size_t>(pair.p)].tiles;
  const auto& of_q = (*patches)[static_cast<std::size_t>(pair.q)].tiles;
  std::array<std::pair<int, int>, lanes> tiles;
  TileShapes::Features may;
  for (std::size_t i = 0; i < lanes; ++i) {
    const auto number = static_cast<std::size_t>(pairs[std::min(i, count - 1)]);
    const int a = of_p[number / lanes], b = of_q[number % lanes];
    tiles[i] = {a, b};
    const NearestDistances::OfTiles of_tiles = nearest->of_tiles(a, b);
    for (std::size_t k = 0; k < TileFeatures::count; ++k) may[k][i] = of_tiles[k];
  }
  TileShapes::Distances distances;
  shapes.measure(pair.p, pair.q, pairs, count, distances);
  Judged judged;
  judge(distances.values, may, shapes.rounding(pair.p, pair.q), static_cast<float>(within), judged);
  for (std::size_t i = 0; i < count; ++i) {
    pair.to_meet = std::min<double>(pair.to_meet, judged.to_meet[i]);
    pair.to_touch = std::min<double>(pair.to_touch, judged.to_touch[i]);
    const auto& [a, b] = tiles[i];
    const bool border = nearest->at_border(a) || nearest->at_border(b);
    for (int left = judged.near[i] | judged.meet[i]; left != 0; left &= left - 1) {
      const auto k = static_cast<std::size_t>(__builtin_ctz(static_cast<unsigned>(left)));
      const bool is_near = (judged.near[i] >> k & 1) != 0,
                 may_meet = (judged.meet[i] >> k & 1) != 0;
      const float distance = distances.values[k][i], nearest_of = may[k][i];
      if (is_near && k >= TileFeatures::points) {
        pair.edges.push_back({a, b, static_cast<int>(k), distance - nearest_of});
      } else if (is_near) {
        // Beyond the border no other triangle is nearer.
        const bool is_its = distances.within[k][i] > -beside || distance < nearest_of || border;
        if (is_its) propose(features.pair(a, b, k), distance, nearest_of, found);
      }
      if (may_meet) {
        SurfacePair both = features.pair(a, b, k);
        both.nearest = nearest->of(a, b, k);
        const Separation s = separation(both, last);
        if (s.distance <= within) found.meet.push_back({key_of(both, a, b, k), both, s});
      }
    }
  }
}

}  // namespace clothsim
