#include "clothsim/search/near_pairs.h"

#include <algorithm>
#include <cmath>

#include "clothsim/geometry/box_tree.h"
#include "near_pairs_impl.h"

namespace clothsim {
namespace {

/// Pairs count as touching from this far beyond the nearest they may come, of the least distance at
/// rest: with a third of it, some of a pile at rest come and go.
constexpr double margin_share = 0.036;

/// Patches that are near each other are measured anew after so many looks, however still they lie:
/// what is found late is found then.
constexpr int longest_sleep = 256;

}  // namespace

NearPairs::Impl::Impl(const Cloth& cloth)
    : mesh(std::make_shared<SurfaceMesh>(cloth)),
      nearest(std::make_shared<NearestDistances>(cloth)),
      patches(std::make_shared<std::vector<Patch>>(cut_into_patches(cloth))),
      features(cloth.columns),
      shapes(cloth, patches),
      slots(mesh, nearest),
      is_shaped(patches->size(), 0) {
  const Points& x = cloth.rest_positions;
  const double along_row = (x.row(1) - x.row(0)).norm();
  const double along_column = (x.row(cloth.columns) - x.row(0)).norm();
  sees = Patch::side * std::min(along_row, along_column);
  paired = SurfaceSlots::reach * nearest->most() + sees;
  // A point and the long side of a triangle; two diagonals side by side are as far apart.
  margin = margin_share * along_row * along_column / std::hypot(along_row, along_column);
}

/// Pairs the patches that are near enough; those that were paired before go on.
void NearPairs::Impl::pair_patches(const Points& positions) {
  std::vector<Box> boxes, wider;
  for (const Patch& patch : *patches) {
    boxes.push_back(around(positions, patch.points));
    wider.push_back(boxes.back());
    wider.back().min().array() -= paired / 2;
    wider.back().max().array() += paired / 2;
  }
  std::vector<PatchPair> pairs;
  const auto add = [&](int p, int q) {
    PatchPair pair{p, q};
    const auto old = std::lower_bound(patch_pairs.begin(), patch_pairs.end(), pair);
    if (old != patch_pairs.end() && !(pair < *old)) {
      pairs.push_back(std::move(*old));
      return;
    }
    pair.to_meet = std::sqrt(boxes[static_cast<std::size_t>(p)].squaredExteriorDistance(
        boxes[static_cast<std::size_t>(q)]));
    pair.to_touch = pair.to_meet - nearest->most();
    pairs.push_back(pair);
  };
  for (int p = 0; p < static_cast<int>(patches->size()); ++p) add(p, p);
  BoxTree(wider).visit_overlaps(add);
  std::sort(pairs.begin(), pairs.end());
  patch_pairs = std::move(pairs);
  paired_nearer = 0;
}

/// How much nearer patches come on straight ways from where they are.
void NearPairs::Impl::foresee(const Points& ends, const Workers& workers) {
  motions.follow(*patches, last, ends, workers);
  if (paired_nearer + motions.most() > sees) pair_patches(last);
  workers.share(
      static_cast<int>(patch_pairs.size()),
      [&](int begin, int end) {
        for (int k = begin; k < end; ++k) {
          PatchPair& pair = patch_pairs[static_cast<std::size_t>(k)];
          pair.step = motions.between(pair.p, pair.q);
        }
      },
      Workers::dear);
}

/// They have gone there.
void NearPairs::Impl::arrive(const Points& ends) {
  for (PatchPair& pair : patch_pairs) {
    pair.to_touch -= pair.step;
    pair.to_meet -= pair.step;
    for (Edges& of : pair.edges) of.gap -= pair.step;
  }
  paired_nearer += motions.most();
  last = ends;
  std::fill(is_shaped.begin(), is_shaped.end(), 0);
}

/// Points may be elsewhere than they have been followed to.
void NearPairs::Impl::be_at(const Points& positions, const Workers& workers) {
  if (last.rows() == 0) {
    last = positions;
    pair_patches(positions);
  } else if (last != positions) {
    foresee(positions, workers);
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
  workers.share(
      static_cast<int>(missing.size()),
      [&](int begin, int end) {
        for (int k = begin; k < end; ++k) shapes.update(missing[static_cast<std::size_t>(k)], last);
      },
      Workers::dear);
}

/// Measures pairs of patches, and returns all features that may come within a `floor` [m] on the
/// way looked at last; none at -infinity.
std::vector<NearPair> NearPairs::Impl::measure_all(const std::vector<int>& due, double floor,
                                                   const Workers& workers, WorkBudget* budget) {
  shape(due, workers);
  const auto bands = workers.gather<Found>(
      static_cast<int>(due.size()),
      [&](int begin, int end, Found& found) {
        for (int k = begin; k < end; ++k) {
          if (budget && budget->is_spent()) break;  // what was begun is taken back
          PatchPair& pair = patch_pairs[static_cast<std::size_t>(due[static_cast<std::size_t>(k)])];
          measure(pair, pair.step + floor, found);
          if (budget) budget->spend(WorkBudget::patches_measured);
        }
      },
      Workers::uneven);
  std::vector<SurfaceSlots::Proposal> proposals;
  std::vector<NearPair> meet;
  for (const Found& found : bands) {
    proposals.insert(proposals.end(), found.proposals.begin(), found.proposals.end());
    meet.insert(meet.end(), found.meet.begin(), found.meet.end());
  }
  slots.add(std::move(proposals), last);
  return meet;
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
  const auto bands = workers.gather<std::vector<NearPair>>(
      static_cast<int>(last.rows()), [&](int begin, int end, std::vector<NearPair>& found) {
        for (int point = begin; point < end; ++point) {
          for (const SurfaceSlots::Slot& slot : slots.of(point)) {
            const SurfacePair pair = slots.pair(slot);
            const auto& [a, b, c, d] = pair.points;
            const double way = ways[a] + std::max({ways[b], ways[c], ways[d]});
            if (slot.gap() > std::max(way, margin)) continue;
            if (!may_touch(pair, slot.last, ahead)) continue;
            const auto key =
                static_cast<std::uint64_t>(point) << 32 | static_cast<std::uint64_t>(slot.number);
            found.push_back({key, pair, slot.last});
          }
        }
      });
  for (const auto& found : bands) near.insert(near.end(), found.begin(), found.end());
}

/// Edges on lists, by their keys.
void NearPairs::Impl::collect_edges(const Points& ahead) {
  const auto first = static_cast<std::ptrdiff_t>(near.size());
  for (PatchPair& of : patch_pairs) {
    for (Edges& listed : of.edges) {
      if (listed.gap > of.step + margin) continue;
      const auto number = static_cast<std::size_t>(listed.number);
      SurfacePair pair = features.pair(listed.a, listed.b, number);
      const Separation s = separation(pair, last);
      pair.nearest = nearest->of(listed.a, listed.b, number);
      listed.gap = s.distance - pair.nearest;
      if (std::count(s.weights.begin(), s.weights.end(), 0.0) > 0) continue;
      if (!may_touch(pair, s, ahead)) continue;
      near.push_back({key_of(pair, listed.a, listed.b, number), pair, s});
    }
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
  const std::int64_t walked = impl.slots.walk(positions, workers);
  if (budget) budget->spend(walked);
  // Those are due that may touch in a step like the last one, and some of what is near.
  std::vector<int> due;
  const double near = SurfaceSlots::reach * impl.nearest->most();
  const int turn = impl.looks++ % longest_sleep;
  for (int k = 0; k < static_cast<int>(impl.patch_pairs.size()); ++k) {
    const Impl::PatchPair& pair = impl.patch_pairs[static_cast<std::size_t>(k)];
    const bool has_turn = k % longest_sleep == turn && pair.to_meet < near;
    if (pair.step > pair.to_touch || has_turn) due.push_back(k);
  }
  impl.measure_all(due, -TileShapes::infinity, workers, budget);
  impl.near.clear();
  impl.collect_points(ahead, workers);
  impl.collect_edges(ahead);
  return impl.near;
}

std::vector<NearPair> NearPairs::may_meet(const Points& here, const Points& ends, double floor,
                                          const Workers& workers, WorkBudget* budget) {
  Impl& impl = *impl_;
  impl.be_at(here, workers);
  impl.foresee(ends, workers);
  std::vector<int> due;
  for (int k = 0; k < static_cast<int>(impl.patch_pairs.size()); ++k) {
    const Impl::PatchPair& pair = impl.patch_pairs[static_cast<std::size_t>(k)];
    if (pair.step + floor >= pair.to_meet) due.push_back(k);
  }
  return impl.measure_all(due, floor, workers, budget);
}

void NearPairs::go(const Points& ends) { impl_->arrive(ends); }

double NearPairs::most_nearer() const { return impl_->motions.most(); }
double NearPairs::sees() const { return impl_->sees; }
double NearPairs::least_nearest() const { return impl_->nearest->least(); }

}  // namespace clothsim
