// What two patches that are awake have near each other: near_pairs.cpp says when they are.

#include <algorithm>
#include <cmath>

#include "clothsim/model/target_clones.h"
#include "near_pairs_impl.h"

namespace clothsim {
namespace {

/// Numbers for the pairs of features of two cells, in their key.
constexpr int keys_of_cells = 64;

/// Which of some pairs of cells wake before their patches have `moved` so far: vectorised.
CLOTHSIM_TARGET_CLONES
void wake(int count, double moved, const double* __restrict wake_at, char* __restrict wakes) {
  for (int k = 0; k < count; ++k) wakes[k] = wake_at[k] <= moved;
}

template <typename T>
const T& of(const std::vector<T>& list, int i) {
  return list[static_cast<std::size_t>(i)];
}

}  // namespace

/// At least: by their boxes, or where they touch on the cloth, by how far they are from folded.
double NearPairs::Impl::gap_of_patches(const PatchPair& pair) const {
  const auto [first_column, last_column] =
      std::minmax({pair.p % patch_columns, pair.q % patch_columns});
  const auto [first_row, last_row] = std::minmax({pair.p / patch_columns, pair.q / patch_columns});
  if (last_column - first_column > 1 || last_row - first_row > 1) {
    return std::sqrt(of(boxes, pair.p).squaredExteriorDistance(of(boxes, pair.q))) - contact;
  }
  GradientBounds bounds;
  for (int r = first_row; r <= last_row; ++r) {
    for (int c = first_column; c <= last_column; ++c) {
      bounds.extend(of(gradients, r * patch_columns + c));
    }
  }
  const double unfolded = least_stretch(bounds) - NearestDistances::neighbour_share;
  return unfolded > 0 ? unfolded * least_rest_distance : -infinity;
}

/// Puts what is within `reach` on the pair's list, once the cells are measured.
void NearPairs::Impl::seek(const Points& positions, double reach, PatchPair& pair,
                           Scratch& scratch) const {
  const std::vector<int>& p = of(patches, pair.p).cells;
  const std::vector<int>& q = of(patches, pair.q).cells;
  if (pair.cells_wake_at.empty()) {
    pair.cells_wake_at.assign(cells_of_patches, infinity);
    for (std::size_t i = 0; i < p.size(); ++i) {
      for (std::size_t j = pair.p == pair.q ? i : 0; j < q.size(); ++j) {  // each two once
        pair.cells_wake_at[i * cells_of_patch + j] = -infinity;
      }
    }
  }
  for (std::vector<Listed>& list : pair.lists) list.clear();
  pair.list_until = pair.moved + reach;

  // Most sleep on.
  std::array<char, cells_of_patches> wakes;
  double* const wake_at = pair.cells_wake_at.data();
  wake(cells_of_patches, pair.list_until, wake_at, wakes.data());
  for (int k = 0; k < cells_of_patches; ++k) {
    if (!wakes[k]) continue;
    const int cell = of(p, k / cells_of_patch), other = of(q, k % cells_of_patch);
    const double most_nearest = nearest.most_of_cells(cell, other);
    const double gap = distance_of_cells(cell, other) - most_nearest;
    if (gap > reach) {
      wake_at[k] = pair.moved + gap;
      continue;
    }
    const FeaturePairs::Runs& runs = feature_pairs.of(cell, other);
    measure_later(positions, {&pair, k, {cell, other}, most_nearest, reach, &runs, {}}, scratch);
  }
}

/// At least: between planes square to the line between their centres.
double NearPairs::Impl::distance_of_cells(int cell, int other) const {
  const Outline &a = of(outlines, cell), &b = of(outlines, other);
  const Vector3 way = b.centre - a.centre;
  const double between =
      (way.transpose() * b.corners).minCoeff() - (way.transpose() * a.corners).maxCoeff();
  return between > 0 ? between / way.norm() : 0;
}

/// Puts all features of two cells among those to be measured.
void NearPairs::Impl::measure_later(const Points& positions, Cells cells, Scratch& scratch) const {
  auto& distances = scratch.distances;
  if (std::min(distances[0].room(), distances[1].room()) < FeaturePairs::most) {
    measure_cells(positions, scratch);
  }
  cells.first = scratch.sizes();
  scratch.cells.push_back(cells);
  const std::array<int, 2> first = feature_pairs.first_points(cells.cells[0], cells.cells[1]);
  for (const FeaturePairs::Run& run : *cells.runs) distances[run.edges].add(run, first);
}

void NearPairs::Impl::measure_cells(const Points& positions, Scratch& scratch) const {
  for (Distances& distances : scratch.distances) distances.measure(positions);
  for (const Cells& cells : scratch.cells) {
    PatchPair& pair = *cells.of;
    auto key = static_cast<unsigned>(cells.number * keys_of_cells);
    std::array<std::size_t, 2> next = cells.first;
    double least = infinity;
    for (const FeaturePairs::Run& run : *cells.runs) {
      for (std::size_t k = 0; k < run.size(); ++k, ++key) {
        const double distance = scratch.distances[run.edges][next[run.edges]++];
        least = std::min(least, distance);
        if (distance > cells.most_nearest + cells.reach) continue;
        const SurfacePair features = features_of(cells.cells, run, k);
        if (distance <= features.nearest + cells.reach) {
          pair.lists[run.edges].push_back({features, key});
        }
      }
    }
    const double gap = least - cells.most_nearest;
    pair.cells_wake_at[static_cast<std::size_t>(cells.number)] = pair.moved + gap;
  }
  scratch.cells.clear();
  for (Distances& distances : scratch.distances) distances.clear();
}

/// Pair `k` of a run of two cells.
SurfacePair NearPairs::Impl::features_of(const std::array<int, 2>& cells,
                                         const FeaturePairs::Run& run, std::size_t k) const {
  const std::array<int, 2> first = feature_pairs.first_points(cells[0], cells[1]);
  SurfacePair pair{SurfacePair::no_triangle, {}, 0};
  for (std::size_t i = 0; i < 4; ++i) pair.points[i] = first[run.of_point(i)] + run.points[i][k];
  if (!run.edges) pair.triangle = 2 * cells[run.of[1]] + run.triangles[k];
  pair.nearest = nearest.of(pair);
  return pair;
}

/// Finds what is asked for on the lists of the pairs that are awake, of one kind.
void NearPairs::Impl::look_at_lists(const Query& query, bool edges, Scratch& scratch) const {
  Distances& distances = scratch.distances[edges];
  for (const auto& [pair, reach] : scratch.awake) {
    const std::vector<Listed>& list = pair->lists[edges];
    const Listed* begin = list.data();
    const Listed* const end = begin + list.size();
    while (begin != end) {
      if (distances.room() == 0) measure_parts(query, edges, scratch);
      const std::size_t first = distances.size();
      const Listed* const stop =
          begin + std::min(static_cast<std::size_t>(end - begin), distances.room());
      scratch.parts.push_back({pair, reach, begin, stop, first});
      for (; begin != stop; ++begin) distances.add(begin->features.points);
    }
  }
  measure_parts(query, edges, scratch);
}

void NearPairs::Impl::measure_parts(const Query& query, bool edges, Scratch& scratch) const {
  Distances& distances = scratch.distances[edges];
  distances.measure(query.positions);
  for (const Part& part : scratch.parts) {
    PatchPair& pair = *part.of;
    const std::uint64_t key =
        static_cast<std::uint64_t>(pair.p) << 40 | static_cast<std::uint64_t>(pair.q) << 16;
    double least_gap = infinity, least_distance = infinity;
    std::size_t k = part.first;
    for (const Listed* listed = part.begin; listed != part.end; ++listed, ++k) {
      const double distance = distances[k];
      const double gap = distance - listed->features.nearest;
      least_gap = std::min(least_gap, gap);
      least_distance = std::min(least_distance, distance);
      if (gap > part.reach || distance > query.distance) continue;
      if (query.ahead) {
        if (edges && distances.at_end(k)) continue;
        if (gap > least_margin() && gap_along(distances.direction(k), listed->features,
                                              *query.ahead) > listed->features.nearest) {
          continue;
        }
      }
      scratch.found[edges].push_back({key | listed->key, &listed->features});
    }
    pair.wake_at = std::min(pair.wake_at, pair.moved + least_gap);
    pair.meet_at = std::min(pair.meet_at, pair.moved + least_distance);
  }
  scratch.parts.clear();
  distances.clear();
}

/// Both kinds in the order of their keys, measured one by one.
void NearPairs::Impl::keep_found(const Query& query, Scratch& scratch) const {
  auto& [points, edges] = scratch.found;
  const auto keep = [&](const Found& found) {
    const SurfacePair& features = *found.features;
    const Separation s = separation(features, query.positions);
    if (s.distance <= query.distance) scratch.near.push_back({found.key, features, s});
  };
  auto point = points.begin();
  for (const Found& edge : edges) {
    for (; point != points.end() && point->key < edge.key; ++point) keep(*point);
    keep(edge);
  }
  std::for_each(point, points.end(), keep);
  points.clear();
  edges.clear();
}

}  // namespace clothsim
