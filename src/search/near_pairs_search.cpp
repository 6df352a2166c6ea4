// What two patches that are awake have near each other: near_pairs.cpp says when they are.

#include <algorithm>
#include <cmath>

#include "near_pairs_impl.h"

namespace clothsim {
namespace {

/// Numbers for the pairs of features of two cells, in their key.
enum : std::size_t { keys_of_cells = 64 };
static_assert(CellOutlines::pairs * keys_of_cells <= 1 << 16, "the end of a key is 16 bits");

/// A key, but for its end: the cells of the patches and the features of these.
std::uint64_t key_of(int p, int q) {
  return static_cast<std::uint64_t>(p) << 40 | static_cast<std::uint64_t>(q) << 16;
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

/// Makes new lists for the pair, and finds what is asked for, once the cells are measured.
void NearPairs::Impl::seek(const Query& query, PatchPair& pair, Scratch& scratch) const {
  const std::vector<int>& p = of(patches, pair.p).cells;
  const std::vector<int>& q = of(patches, pair.q).cells;
  for (List& list : pair.lists) list.clear();
  pair.listed_at = pair.moved;
  pair.list_until = pair.moved + looks * std::max(query.within(pair), least_margin());
  pair.wake_at.fill(pair.list_until);
  const double reach = pair.list_until - pair.moved;

  query.spend(WorkBudget::outlines_compared);
  std::array<int, CellOutlines::pairs> near_cells;
  std::array<double, CellOutlines::pairs> distances;
  const std::size_t count =
      outlines.look(static_cast<std::size_t>(pair.p), static_cast<std::size_t>(pair.q),
                    contact + reach, distances.data(), near_cells.data());
  for (std::size_t i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(near_cells[i]);
    const std::array<int, 2> cells{p[k / CellOutlines::cells], q[k % CellOutlines::cells]};
    const double most = pair.are_neighbours ? nearest.most_of_cells(cells[0], cells[1]) : contact;
    const std::array<double, 2> most_nearest{most, nearest.most_of_edges(cells[0], cells[1])};
    for (const bool edges : {false, true}) {
      if (distances[k] > most_nearest[edges] + reach) continue;
      measure_later(query, edges, {&pair, k, cells, most_nearest[edges], reach}, scratch);
    }
  }
}

/// Puts two cells among those whose features of a kind are to be measured.
void NearPairs::Impl::measure_later(const Query& query, bool edges, const Cells& cells,
                                    Scratch& scratch) const {
  const std::size_t number = feature_pairs.number(cells.cells[0], cells.cells[1]);
  std::vector<Cells>& others = scratch.cells[edges][number];
  others.push_back(cells);
  const std::size_t most = std::max(std::size_t{1}, feature_pairs[number][edges].size());
  if ((others.size() + 1) * most > Distances::capacity) {
    measure_cells(query, edges, number, scratch);
  }
}

/// Puts what is near of some cells with the same list of features on the lists of their patches,
/// and finds what is asked for among it.
void NearPairs::Impl::measure_cells(const Query& query, bool edges, std::size_t number,
                                    Scratch& scratch) const {
  std::vector<Cells>& all = scratch.cells[edges][number];
  const std::vector<FeaturePairs::Pair>& list = feature_pairs[number][edges];
  if (!query.spend(all.size() * list.size())) all.clear();
  const std::size_t count = all.size();
  if (count == 0) return;
  std::array<std::array<int, Distances::capacity>, 2> firsts;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < 2; ++k) firsts[k][i] = feature_pairs.first_point(all[i].cells[k]);
  }
  Distances& distances = scratch.distances[edges];
  for (const FeaturePairs::Pair& pair : list) {
    std::array<const int*, 4> of;
    for (std::size_t k = 0; k < 4; ++k) of[k] = firsts[pair.of[k]].data();
    distances.add(count, of, pair.points);
  }
  distances.measure(query.positions);

  std::array<double, Distances::capacity> most;
  for (std::size_t i = 0; i < count; ++i) {
    most[i] = all[i].most_nearest + all[i].reach;
  }
  std::size_t listed_now = 0, first = 0;
  std::size_t key = edges ? feature_pairs[number][0].size() : 0;  // in those of its cells
  for (const FeaturePairs::Pair& pair : list) {
    const double* const distance = distances.values() + first;
    for (std::size_t i = 0; i < count; ++i) {
      if (distance[i] > most[i]) continue;
      SurfacePair features{pair.triangle, pair.points, contact};
      for (std::size_t k = 0; k < 4; ++k) features.points[k] += firsts[pair.of[k]][i];
      PatchPair& of_patches = *all[i].of;
      if (edges || of_patches.are_neighbours) features.nearest = nearest.of(features);
      if (distance[i] > features.nearest + all[i].reach) continue;
      const Listed listed{features.points, rounded_up(features.nearest),
                          static_cast<unsigned>(all[i].number * keys_of_cells + key)};
      List& of_kind = of_patches.lists[edges];
      of_kind.features.push_back(listed);
      of_kind.wake_at.push_back(consider(query, distances, first + i, listed, of_patches, scratch));
      ++listed_now;
    }
    first += count;
    ++key;
  }
  distances.clear();
  query.spend(WorkBudget::pair_listed * listed_now);
  all.clear();
}

/// Finds what is asked for on the lists of the pairs that are awake, of one kind.
void NearPairs::Impl::look_at_lists(const Query& query, bool edges, Scratch& scratch) const {
  Distances& distances = scratch.distances[edges];
  for (PatchPair* const pair : scratch.awake) {
    const double within = query.within(*pair);
    double& wake_at = pair->wake_at[edges];
    if (wake_at > pair->moved + within) continue;
    wake_at = pair->list_until;  // until its list has been looked at
    const List& list = pair->lists[edges];
    const double since = pair->moved + within - pair->listed_at;
    const auto until = static_cast<float>(since + rounding * std::abs(since));
    float next = std::numeric_limits<float>::infinity();
    for (std::size_t k = 0; k < list.features.size(); ++k) {
      if (list.wake_at[k] > until) {
        next = std::min(next, list.wake_at[k]);
        continue;
      }
      if (distances.room() == 0) measure_awake(query, edges, scratch);
      scratch.features.push_back({pair, k});
      distances.add(list.features[k].points);
    }
    wake_at = std::min(wake_at, pair->listed_at + static_cast<double>(next));
  }
  measure_awake(query, edges, scratch);
}

void NearPairs::Impl::measure_awake(const Query& query, bool edges, Scratch& scratch) const {
  Distances& distances = scratch.distances[edges];
  if (!query.spend(distances.size())) scratch.features.clear();
  distances.measure(query.positions);
  std::size_t k = 0;
  for (const Awake& awake : scratch.features) {
    List& list = awake.of->lists[edges];
    list.wake_at[awake.place] =
        consider(query, distances, k++, list.features[awake.place], *awake.of, scratch);
  }
  scratch.features.clear();
  distances.clear();
}

/// Are features, whose distance is number `k`, asked for?
bool NearPairs::Impl::is_asked_for(const Query& query, double within, const Distances& distances,
                                   std::size_t k, const std::array<int, 4>& points,
                                   double least) const {
  const double gap = distances[k] - least;
  if (gap > within || distances[k] > query.distance) return false;
  if (!query.ahead) return true;
  if (distances.edges() && distances.at_end(k)) return false;
  const SurfacePair features{distances.edges() ? SurfacePair::no_triangle : 0, points, least};
  return gap <= least_margin() ||
         gap_along(distances.direction(k), features, *query.ahead) <= least;
}

/// Takes the distance, number `k`, that features on the list of a pair have now. Returns when they
/// wake.
float NearPairs::Impl::consider(const Query& query, const Distances& distances, std::size_t k,
                                const Listed& listed, PatchPair& pair, Scratch& scratch) const {
  const double wake_at = pair.moved + distances[k] - static_cast<double>(listed.nearest);
  double& first = pair.wake_at[distances.edges()];
  first = std::min(first, wake_at);
  const auto least = static_cast<double>(listed.nearest);
  if (is_asked_for(query, query.within(pair), distances, k, listed.points, least)) {
    scratch.found.push_back(key_of(pair.p, pair.q) | listed.key);
  }
  const double since = wake_at - pair.listed_at;
  return static_cast<float>(since - rounding * std::abs(since));
}

/// In the order of their keys, measured one by one.
void NearPairs::Impl::keep_found(const Query& query, Scratch& scratch) const {
  if (!query.spend(WorkBudget::pair_found * scratch.found.size())) scratch.found.clear();
  std::sort(scratch.found.begin(), scratch.found.end());
  for (const std::uint64_t key : scratch.found) {
    const SurfacePair features = features_of(key);
    const Separation s = separation(features, query.positions);
    if (s.distance <= query.distance) scratch.near.push_back({key, features, s});
  }
  scratch.found.clear();
}

SurfacePair NearPairs::Impl::features_of(std::uint64_t key) const {
  const auto p = static_cast<int>(key >> 40), q = static_cast<int>(key >> 16 & 0xffffff);
  const auto end = static_cast<std::size_t>(key & 0xffff);
  const std::array<int, 2> cells{of(patches, p).cells[end / keys_of_cells / CellOutlines::cells],
                                 of(patches, q).cells[end / keys_of_cells % CellOutlines::cells]};
  const FeaturePairs::List& list = feature_pairs[feature_pairs.number(cells[0], cells[1])];
  std::size_t k = end % keys_of_cells;
  const bool edges = k >= list[0].size();
  if (edges) k -= list[0].size();
  const FeaturePairs::Pair& features = list[edges][k];

  SurfacePair pair{SurfacePair::no_triangle, features.points, 0};
  for (std::size_t i = 0; i < 4; ++i) {
    pair.points[i] += feature_pairs.first_point(cells[features.of[i]]);
  }
  if (!edges) pair.triangle = 2 * cells[features.of[1]] + features.triangle;
  pair.nearest = nearest.of(pair);
  return pair;
}

}  // namespace clothsim
