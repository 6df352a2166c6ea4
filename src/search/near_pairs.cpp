#include "clothsim/search/near_pairs.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <iterator>
#include <map>
#include <mutex>
#include <numeric>

#include "near_pairs_impl.h"

namespace clothsim {
namespace {

/// Pairs count as touching from this far beyond the nearest they may come, of the least distance at
/// rest: with a third of it, some of a pile at rest come and go.
constexpr double margin_share = 0.036;

/// Patches that are so many times as far as they may come nearer in a step need no closer bound.
constexpr double far_off = 8;

/// Patches that are near each other are measured anew after so many looks, however still they lie:
/// what is found late is found then.
constexpr int longest_sleep = 256;

/// The number of a pair of patches that is paired no more.
constexpr int gone = -1;

/// Tiles from one of a patch to the nearest of one so many patches on.
int least_way(int patches_on) { return std::max(0, (std::abs(patches_on) - 1) * Patch::side + 1); }

}  // namespace

NearPairs::Impl::Impl(const Cloth& cloth)
    : columns(cloth.columns),
      mesh(std::make_shared<SurfaceMesh>(cloth)),
      nearest(std::make_shared<NearestDistances>(cloth)),
      patches(std::make_shared<std::vector<Patch>>(cut_into_patches(cloth))),
      patch_columns((cloth.columns + Patch::side - 1) / Patch::side),
      features(cloth.columns),
      shapes(cloth, patches->size()),
      slots(mesh, nearest) {
  const Points& x = cloth.rest_positions;
  const double along_row = (x.row(1) - x.row(0)).norm();
  const double along_column = (x.row(columns) - x.row(0)).norm();
  spacing = std::min(along_row, along_column);
  fill_nearest();
  // A point and the long side of a triangle; two diagonals side by side are as far apart.
  margin = margin_share * along_row * along_column / std::hypot(along_row, along_column);
}

/// What the outlines of tiles are compared with.
void NearPairs::Impl::fill_nearest() {
  nearest_far.fill(static_cast<float>(nearest->far()));
  for (std::size_t k = 0; k < TileFeatures::count; ++k) {
    far_rows[k].fill(
        static_cast<float>(k < TileFeatures::points ? nearest->far() : nearest->far_inside()));
  }
  const auto is_neighbour = [&](int patches_on) {
    const int gap = least_way(patches_on);
    return nearest->are_neighbours(gap, 0) || nearest->are_neighbours(0, gap);
  };
  while (is_neighbour(near_patches + 1)) ++near_patches;
  constexpr int side = Patch::side, tiles = TileShapes::tiles;
  for (int r = -near_patches; r <= near_patches; ++r) {
    for (int c = -near_patches; c <= near_patches; ++c) {
      TileShapes::PairValues values;
      for (int k = 0; k < tiles * tiles; ++k) {
        const int i = k / tiles, j = k % tiles;
        const int along_row = c * side + j % side - i % side;
        const int along_column = r * side + j / side - i / side;
        float most = static_cast<float>(nearest->far());
        if (nearest->are_neighbours(along_row, along_column)) {
          const auto& of = nearest->of_tiles(along_row, along_column);
          most = *std::max_element(of.begin(), of.end());
        }
        values[static_cast<std::size_t>(k)] = most;
      }
      nearest_of_tiles.push_back(values);
    }
  }
}

double NearPairs::Impl::sees() const { return Patch::side * spacing; }

/// Are they so near on the cloth that they may come nearer than others?
bool NearPairs::Impl::are_neighbours(int p, int q) const {
  return nearest->are_neighbours(least_way(p % patch_columns - q % patch_columns),
                                 least_way(p / patch_columns - q / patch_columns));
}

/// Pairs the patches that are near enough; those that were paired before go on.
void NearPairs::Impl::pair_patches(const Points& positions) {
  const double reach = SurfaceSlots::reach * nearest->far() + sees();
  std::vector<Box> boxes, wider;
  for (const Patch& patch : *patches) {
    boxes.push_back(around(positions, patch.points));
    wider.push_back(boxes.back());
    wider.back().min().array() -= reach / 2;
    wider.back().max().array() += reach / 2;
  }
  std::vector<PatchPair> pairs;
  const auto add = [&](int p, int q) {
    PatchPair pair{p, q, are_neighbours(p, q)};
    pair.to_meet = std::sqrt(boxes[static_cast<std::size_t>(p)].squaredExteriorDistance(
        boxes[static_cast<std::size_t>(q)]));
    pair.to_touch = pair.to_meet - nearest->far();
    pairs.push_back(pair);
  };
  for (int p = 0; p < static_cast<int>(patches->size()); ++p) add(p, p);
  BoxTree(wider).visit_overlaps(add);
  const auto before = [](const PatchPair& a, const PatchPair& b) {
    return a.p < b.p || (a.p == b.p && a.q < b.q);
  };
  std::sort(pairs.begin(), pairs.end(), before);

  // Those that were paired before go on, with their edges.
  std::vector<int> renumbered(patch_pairs.size(), gone);
  std::size_t old = 0;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    while (old < patch_pairs.size() && before(patch_pairs[old], pairs[k])) ++old;
    if (old == patch_pairs.size() || before(pairs[k], patch_pairs[old])) continue;
    pairs[k] = patch_pairs[old];
    renumbered[old] = static_cast<int>(k);
  }
  for (Edges& of : edges) of.pair = renumbered[static_cast<std::size_t>(of.pair)];
  drop_edges([](const Edges& of) { return of.pair == gone; });
  patch_pairs = std::move(pairs);
  paired_nearer = 0;
}

template <typename IsDropped>
void NearPairs::Impl::drop_edges(const IsDropped& is_dropped) {
  edges.erase(std::remove_if(edges.begin(), edges.end(), is_dropped), edges.end());
}

/// Numbers of their edges: three of each tile.
std::uint64_t NearPairs::Impl::edge_key(const Edges& edges) {
  const auto number = static_cast<std::uint64_t>(edges.number) - TileFeatures::points;
  const auto a = 3 * static_cast<std::uint64_t>(edges.a) + number / 3;
  const auto b = 3 * static_cast<std::uint64_t>(edges.b) + number % 3;
  return std::uint64_t{1} << 63 | a << 31 | b;
}

/// How much nearer patches come on straight ways from where they are. Those that may meet, but for
/// a `floor` [m], are `now`.
void NearPairs::Impl::foresee(const Points& ends, double floor, const Workers& workers) {
  motions.follow(*patches, last, ends, workers);
  if (paired_nearer + motions.most() > sees()) pair_patches(last);
  std::mutex mutex;
  std::map<int, std::array<std::vector<int>, 2>> found;  // by the first pair of a band
  workers.share(
      static_cast<int>(patch_pairs.size()),
      [&](int begin, int end) {
        std::array<std::vector<int>, 2> of_band;
        for (int k = begin; k < end; ++k) {
          PatchPair& pair = patch_pairs[static_cast<std::size_t>(k)];
          pair.nearer = moved(pair);
          const double left = std::min(pair.to_touch, pair.to_meet) - pair.nearer;
          const double most = motions.at_most(pair.p, pair.q);
          pair.step = far_off * most < left ? most : motions.between(pair.p, pair.q);
          if (2 * pair.step > pair.to_touch - pair.nearer) of_band[0].push_back(k);
          if (pair.step + floor >= pair.to_meet - pair.nearer) of_band[1].push_back(k);
        }
        const std::lock_guard<std::mutex> lock(mutex);
        found[begin] = std::move(of_band);
      },
      Workers::dear);
  has_gone = false;
  soon.clear();
  now.clear();
  for (const auto& [begin, of_band] : found) {
    soon.insert(soon.end(), of_band[0].begin(), of_band[0].end());
    now.insert(now.end(), of_band[1].begin(), of_band[1].end());
  }
}

/// They have gone there.
void NearPairs::Impl::arrive(const Points& ends) {
  has_gone = true;
  paired_nearer += motions.most();
  last = ends;
  std::fill(is_shaped.begin(), is_shaped.end(), 0);
}

/// Points may be elsewhere than they have been followed to.
void NearPairs::Impl::be_at(const Points& positions, const Workers& workers) {
  if (last.rows() == 0) {
    last = positions;
    has_gone = false;
    is_shaped.assign(patches->size(), 0);
    pair_patches(positions);
    soon.resize(patch_pairs.size());
    std::iota(soon.begin(), soon.end(), 0);
  } else if (last != positions) {
    foresee(positions, 0, workers);
    arrive(positions);
  }
}

/// Where the tiles of patches are that are due.
void NearPairs::Impl::shape(const std::vector<int>& due, const Workers& workers) {
  std::vector<int> missing;
  for (const int k : due) {
    const PatchPair& pair = patch_pairs[static_cast<std::size_t>(k)];
    for (const int p : {pair.p, pair.q}) {
      char& is = is_shaped[static_cast<std::size_t>(p)];
      if (is == 0) missing.push_back(p);
      is = 1;
    }
  }
  shapes.see_from(row(last, 0));
  workers.share(
      static_cast<int>(missing.size()),
      [&](int begin, int end) {
        for (int k = begin; k < end; ++k) {
          const int p = missing[static_cast<std::size_t>(k)];
          shapes.update(p, (*patches)[static_cast<std::size_t>(p)], last);
        }
      },
      Workers::dear);
}

/// Measures pairs of patches, and returns all features within of(pair) [m] of each other.
template <typename Within>
std::vector<NearPair> NearPairs::Impl::measure_all(const std::vector<int>& due,
                                                   const Within& within, const Workers& workers,
                                                   WorkBudget* budget) {
  if (due.empty()) return {};
  shape(due, workers);
  scratches.resize(static_cast<std::size_t>(workers.threads() * Workers::uneven));
  for (Scratch& scratch : scratches) scratch.band = -1;
  std::atomic<std::size_t> used{0};
  workers.share(
      static_cast<int>(due.size()),
      [&](int begin, int end) {
        Scratch& scratch = scratches[used++];
        scratch.band = begin;
        scratch.proposals.clear();
        scratch.found.clear();
        scratch.edges.clear();
        for (int k = begin; k < end; ++k) {
          if (budget && budget->is_spent()) break;  // what was begun is taken back
          const int pair = due[static_cast<std::size_t>(k)];
          measure(pair, within(patch_pairs[static_cast<std::size_t>(pair)]), scratch);
          if (budget) budget->spend(WorkBudget::patches_measured);
        }
      },
      Workers::dear, Workers::uneven);

  std::sort(scratches.begin(), scratches.end(),
            [](const Scratch& a, const Scratch& b) { return a.band < b.band; });
  std::vector<SurfaceSlots::Proposal> proposals;
  std::vector<NearPair> found;
  std::vector<char> is_measured(patch_pairs.size(), 0);
  for (const int pair : due) is_measured[static_cast<std::size_t>(pair)] = 1;
  drop_edges([&](const Edges& of) { return is_measured[static_cast<std::size_t>(of.pair)] != 0; });
  for (const Scratch& scratch : scratches) {
    if (scratch.band < 0) continue;
    proposals.insert(proposals.end(), scratch.proposals.begin(), scratch.proposals.end());
    found.insert(found.end(), scratch.found.begin(), scratch.found.end());
    edges.insert(edges.end(), scratch.edges.begin(), scratch.edges.end());
  }
  slots.add(proposals, last);
  return found;
}

/// Are features nearer than the margin, or on the way to where they touch?
bool NearPairs::Impl::may_touch(const SurfacePair& pair, const Separation& s,
                                const Points& ahead) const {
  return s.distance <= pair.nearest + margin || gap_along(s.normal, pair, ahead) <= pair.nearest;
}

/// Slots, by their points and numbers.
void NearPairs::Impl::collect_points(const Points& ahead, const Workers& workers) {
  const Eigen::RowVector3d common = ahead.colwise().mean() - last.colwise().mean();
  const Scalars ways = ((ahead - last).rowwise() - common).rowwise().norm();
  std::mutex mutex;
  std::map<int, std::vector<NearPair>> found;  // by the first slot that a thread looked at
  workers.share(
      static_cast<int>(slots.all().size()),
      [&](int begin, int end) {
        std::vector<NearPair> of_band;
        for (int k = begin; k < end; ++k) {
          const SurfaceSlots::Slot& slot = slots.all()[static_cast<std::size_t>(k)];
          const SurfacePair pair = slots.pair(slot);
          const auto& [a, b, c, d] = pair.points;
          const double way = ways[a] + std::max({ways[b], ways[c], ways[d]});
          if (slot.distance - pair.nearest > std::max(way, margin)) continue;
          const Separation s = separation(pair, last);
          if (!may_touch(pair, s, ahead)) continue;
          const auto key = static_cast<std::uint64_t>(slot.point) << 32 |
                           static_cast<std::uint64_t>(slot.number);
          of_band.push_back({key, pair, s});
        }
        const std::lock_guard<std::mutex> lock(mutex);
        found[begin] = std::move(of_band);
      },
      Workers::dear);
  for (const auto& [begin, pairs] : found) near.insert(near.end(), pairs.begin(), pairs.end());
}

/// Edges on lists, by their keys.
void NearPairs::Impl::collect_edges(const Points& ahead) {
  const auto first = static_cast<std::ptrdiff_t>(near.size());
  for (const Edges& listed : edges) {
    const PatchPair& of = patch_pairs[static_cast<std::size_t>(listed.pair)];
    if (listed.gap > moved(of) + of.step + margin) continue;
    SurfacePair pair = features.pair(listed.a, listed.b, static_cast<std::size_t>(listed.number));
    const Separation s = separation(pair, last);
    if (std::any_of(s.weights.begin(), s.weights.end(), [](double w) { return w == 0; })) continue;
    pair.nearest = nearest->of(pair);
    if (may_touch(pair, s, ahead)) near.push_back({edge_key(listed), pair, s});
  }
  std::sort(near.begin() + first, near.end(),
            [](const NearPair& a, const NearPair& b) { return a.key < b.key; });
}

NearPairs::NearPairs(const Cloth& cloth) : impl_(std::make_unique<Impl>(cloth)) {}
NearPairs::~NearPairs() = default;
NearPairs::NearPairs(const NearPairs& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
NearPairs::NearPairs(NearPairs&&) noexcept = default;
NearPairs& NearPairs::operator=(NearPairs other) noexcept {
  impl_.swap(other.impl_);
  return *this;
}

const std::vector<NearPair>& NearPairs::approaching(const Points& positions, const Points& ahead,
                                                    const Workers& workers, WorkBudget* budget) {
  Impl& impl = *impl_;
  impl.be_at(positions, workers);
  impl.slots.walk(positions, workers);
  if (budget) budget->spend(static_cast<std::int64_t>(impl.slots.all().size()));
  std::vector<int> due;
  const auto pair = [&](int k) -> const Impl::PatchPair& {
    return impl.patch_pairs[static_cast<std::size_t>(k)];
  };
  for (const int k : impl.soon) {
    if (impl.is_due(pair(k))) due.push_back(k);
  }
  const int count = static_cast<int>(impl.patch_pairs.size());
  for (int k = impl.looks++ % longest_sleep; k < count; k += longest_sleep) {
    const bool is_near = pair(k).to_meet < SurfaceSlots::reach * impl.nearest->far();
    if (is_near && !impl.is_due(pair(k))) due.push_back(k);
  }
  impl.measure_all(
      due, [](const Impl::PatchPair&) { return 0.0; }, workers, budget);
  impl.near.clear();
  impl.collect_points(ahead, workers);
  impl.collect_edges(ahead);
  return impl.near;
}

std::vector<NearPair> NearPairs::may_meet(const Points& here, const Points& ends, double floor,
                                          const Workers& workers, WorkBudget* budget) {
  Impl& impl = *impl_;
  impl.be_at(here, workers);
  impl.foresee(ends, floor, workers);
  std::vector<int> soon;
  std::set_union(impl.soon.begin(), impl.soon.end(), impl.now.begin(), impl.now.end(),
                 std::back_inserter(soon));
  impl.soon.swap(soon);
  return impl.measure_all(
      impl.now, [&](const Impl::PatchPair& pair) { return pair.step + floor; }, workers, budget);
}

void NearPairs::go(const Points& ends) { impl_->arrive(ends); }

double NearPairs::most_nearer() const { return impl_->motions.most(); }
double NearPairs::sees() const { return impl_->sees(); }
double NearPairs::least_nearest() const { return impl_->nearest->least(); }
double NearPairs::margin() const { return impl_->margin; }

}  // namespace clothsim
