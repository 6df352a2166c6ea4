// What two patches have near each other: near_pairs.cpp says when they are measured.

#include <algorithm>

#include "clothsim/model/target_clones.h"
#include "near_pairs_impl.h"

namespace clothsim {
namespace {

using Row = TileShapes::Row;
constexpr std::size_t lanes = TileShapes::at_once;

/// Slots are proposed up to this share of a triangle beside it: further out another one is nearer.
constexpr float beside = 0.1F;

/// Edges of layers that points see are listed up to this, of the nearest that they may come: a
/// quarter as far as slots reach.
constexpr float edge_reach = 1 + static_cast<float>(SurfaceSlots::reach - 1) / 4;

/// What distances of sixteen pairs of tiles come to.
struct Judged {
  enum : int { is_near = 1, may_meet = 2 };
  Row to_touch;
  Row to_meet;
  std::array<std::array<int, lanes>, TileFeatures::count> flags;
  std::array<int, TileFeatures::count> any;
};

// As ternaries they are vectorised.
inline float smaller(float a, float b) { return a < b ? a : b; }
inline float larger(float a, float b) { return a > b ? a : b; }

/// `nearest`: that features may come, below 0 where they share a point. `border`: 1 where a tile is
/// at the border, beyond which no other triangle is nearer. `within`: what may meet.
CLOTHSIM_TARGET_CLONES
void judge(const TileShapes::Distances& found, const std::array<Row, TileFeatures::count>& nearest,
           const Row& border, float rounding, float within, Judged& judged) {
  constexpr auto reach = static_cast<float>(SurfaceSlots::reach);
  Row to_touch, to_meet, seen;
  for (std::size_t i = 0; i < lanes; ++i) to_touch[i] = to_meet[i] = TileShapes::far, seen[i] = 0;
  for (std::size_t k = 0; k < TileFeatures::points; ++k) {
    int any = 0;
    for (std::size_t i = 0; i < lanes; ++i) {
      const float may = nearest[k][i];
      const float distance = may < 0 ? TileShapes::far : found.values[k][i] - rounding;
      const bool is_near = distance < reach * may;
      to_meet[i] = smaller(to_meet[i], distance);
      to_touch[i] = smaller(to_touch[i], is_near ? (reach - 1) * may : distance - may);
      seen[i] = is_near ? 1.0F : seen[i];
      const bool is_its =
          is_near & ((found.within[k][i] > -beside) | (distance < may) | (border[i] > 0));
      const int flags =
          (is_its ? Judged::is_near : 0) | (distance <= within ? Judged::may_meet : 0);
      judged.flags[k][i] = flags;
      any |= flags;
    }
    judged.any[k] = any;
  }
  // Where points see a layer, they keep it off before edges touch.
  Row edges_reach, none_touch;
  for (std::size_t i = 0; i < lanes; ++i) {
    edges_reach[i] = seen[i] > 0 ? edge_reach : reach;
    none_touch[i] = seen[i] > 0 ? TileShapes::far : -TileShapes::far;
  }
  for (std::size_t k = TileFeatures::points; k < TileFeatures::count; ++k) {
    int any = 0;
    for (std::size_t i = 0; i < lanes; ++i) {
      const float may = nearest[k][i];
      const float distance = may < 0 ? TileShapes::far : found.values[k][i] - rounding;
      const bool is_near = distance < edges_reach[i] * may;
      const float gap = is_near ? (reach - 1) * may : distance - may;
      to_meet[i] = smaller(to_meet[i], distance);
      to_touch[i] = smaller(to_touch[i], larger(gap, none_touch[i]));
      const int flags =
          (is_near ? Judged::is_near : 0) | (distance <= within ? Judged::may_meet : 0);
      judged.flags[k][i] = flags;
      any |= flags;
    }
    judged.any[k] = any;
  }
  judged.to_touch = to_touch;
  judged.to_meet = to_meet;
}

/// A key of features that are found without a slot.
std::uint64_t key_of(const SurfacePair& pair) {
  const auto at = [&](std::size_t k) { return static_cast<std::uint64_t>(pair.points[k]); };
  if (!pair.edges()) return at(0) << 32 | static_cast<std::uint64_t>(pair.triangle);
  return std::uint64_t{1} << 63 | at(0) << 32 | at(2);
}

/// The way between two tiles, by their number and the way between patches.
std::array<int, 2> way(const std::array<int, 2>& patches, int number) {
  constexpr int side = Patch::side, tiles = TileShapes::tiles;
  const int a = number / tiles, b = number % tiles;
  return {patches[0] + b % side - a % side, patches[1] + b / side - a / side};
}

}  // namespace

/// Sixteen pairs of tiles, or fewer, that are measured at once.
struct NearPairs::Impl::Batch {
  const int* pairs;  // numbers
  std::size_t count;
  bool are_neighbours;
  std::array<std::array<int, 2>, lanes> tiles;
  const TileFeatureRows* nearest = nullptr;  // that features may come [m]
  TileFeatureRows own;
  Row border;  // 1: of a tile at the border
};

/// Finds what has no slot yet, which edges are near, and what is within a distance [m].
void NearPairs::Impl::measure(int number, double within, Scratch& scratch) {
  PatchPair& pair = patch_pairs[static_cast<std::size_t>(number)];
  TileShapes::Near& tiles = scratch.tiles;
  const TileShapes::PairValues& most = pair.are_neighbours ? nearest_of(pair) : nearest_far;
  const float rounding = shapes.rounding(pair.p, pair.q);
  const auto gap = static_cast<float>((SurfaceSlots::reach - 1) * nearest->far());
  shapes.look(pair.p, pair.q, most, gap, static_cast<float>(within) + rounding, tiles);
  pair.nearer -= moved(pair);
  pair.to_meet = std::min<double>(tiles.rest, unbounded) - rounding;
  pair.to_touch = std::min<double>(tiles.rest_gap, unbounded) - rounding;

  int* const begin = tiles.pairs.data();
  int* const end = begin + tiles.count;
  const std::array<int, 2> between = patch_way(pair);
  int* first_neighbours = end;
  if (pair.are_neighbours) {
    first_neighbours = std::partition(begin, end, [&](int k) {
      const auto [along_row, along_column] = way(between, k);
      return !nearest->are_neighbours(along_row, along_column);
    });
  }
  const auto measure_range = [&](const int* from, const int* to, bool are_neighbours) {
    for (; from < to; from += lanes) {
      Batch batch;
      batch.pairs = from;
      batch.count = std::min(static_cast<std::size_t>(to - from), lanes);
      batch.are_neighbours = are_neighbours;
      measure_batch(number, batch, within, scratch);
    }
  };
  measure_range(begin, first_neighbours, false);
  measure_range(first_neighbours, end, true);
}

/// The way between patches, along rows and columns of tiles.
std::array<int, 2> NearPairs::Impl::patch_way(const PatchPair& pair) const {
  return {Patch::side * (pair.q % patch_columns - pair.p % patch_columns),
          Patch::side * (pair.q / patch_columns - pair.p / patch_columns)};
}

/// Nearest that any features of tiles may come, of two patches.
const TileShapes::PairValues& NearPairs::Impl::nearest_of(const PatchPair& pair) const {
  const auto [along_row, along_column] = patch_way(pair);
  const int row = along_column / Patch::side + near_patches;
  const int column = along_row / Patch::side + near_patches;
  return nearest_of_tiles[static_cast<std::size_t>(row * (2 * near_patches + 1) + column)];
}

/// Which tiles they are, and how near their features may come.
void NearPairs::Impl::prepare(const PatchPair& pair, Batch& batch) const {
  const Patch &p = (*patches)[static_cast<std::size_t>(pair.p)],
              &q = (*patches)[static_cast<std::size_t>(pair.q)];
  bool any_border = false;
  for (std::size_t i = 0; i < lanes; ++i) {
    const auto k = static_cast<std::size_t>(batch.pairs[std::min(i, batch.count - 1)]);
    const int a = p.tiles[k / TileShapes::tiles], b = q.tiles[k % TileShapes::tiles];
    batch.tiles[i] = {a, b};
    const bool border = nearest->has_border(a) || nearest->has_border(b);
    batch.border[i] = border ? 1 : 0;
    any_border = any_border || border;
  }
  if (!batch.are_neighbours && !any_border) {
    batch.nearest = &far_rows;
    return;
  }
  const std::array<int, 2> between = patch_way(pair);
  const auto far = static_cast<float>(nearest->far());
  const auto far_inside = static_cast<float>(nearest->far_inside());
  NearestDistances::OfTiles any;
  any.fill(far);
  for (std::size_t i = 0; i < lanes; ++i) {
    const auto [along_row, along_column] = way(between, batch.pairs[std::min(i, batch.count - 1)]);
    const NearestDistances::OfTiles& of =
        batch.are_neighbours ? nearest->of_tiles(along_row, along_column) : any;
    const float most = batch.border[i] > 0 ? far : far_inside;
    for (std::size_t f = 0; f < TileFeatures::points; ++f) batch.own[f][i] = of[f];
    for (std::size_t f = TileFeatures::points; f < TileFeatures::count; ++f) {
      batch.own[f][i] = smaller(of[f], most);
    }
  }
  batch.nearest = &batch.own;
}

void NearPairs::Impl::measure_batch(int number, Batch& batch, double within, Scratch& scratch) {
  PatchPair& pair = patch_pairs[static_cast<std::size_t>(number)];
  TileShapes::Distances& distances = scratch.distances;
  shapes.measure(pair.p, pair.q, batch.pairs, batch.count, distances);
  prepare(pair, batch);
  Judged judged;
  judge(distances, *batch.nearest, batch.border, shapes.rounding(pair.p, pair.q),
        static_cast<float>(within), judged);
  for (std::size_t i = 0; i < batch.count; ++i) {
    pair.to_meet = std::min<double>(pair.to_meet, judged.to_meet[i]);
    pair.to_touch = std::min<double>(pair.to_touch, judged.to_touch[i]);
  }
  for (std::size_t k = 0; k < TileFeatures::count; ++k) {
    for (std::size_t i = 0; judged.any[k] != 0 && i < batch.count; ++i) {
      const int flags = judged.flags[k][i];
      if (flags == 0) continue;
      const auto& [a, b] = batch.tiles[i];
      SurfacePair found = features.pair(a, b, k);
      if ((flags & Judged::is_near) != 0) {
        const double distance = distances.values[k][i], may = (*batch.nearest)[k][i];
        const SurfaceSlots::Proposal proposal{found.points[0], found.triangle};
        if (found.edges()) {
          scratch.edges.push_back({number, a, b, static_cast<int>(k), distance - may});
        } else if (!slots.covers(proposal, distance, may)) {
          scratch.proposals.push_back(proposal);
        }
      }
      if ((flags & Judged::may_meet) != 0) {
        found.nearest = nearest->of(found);
        const Separation s = separation(found, last);
        if (s.distance <= within) scratch.found.push_back({key_of(found), found, s});
      }
    }
  }
}

}  // namespace clothsim
