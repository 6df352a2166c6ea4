#include "clothsim/search/near_pairs.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "clothsim/model/errors.h"

namespace clothsim {
namespace {

/// Margin beyond the contact distance within which pairs count as touching, of the least distance
/// at rest: with a third of it, some pairs of a pile at rest come and go.
constexpr double margin_share = 0.036;

/// Patches that are near each other are measured again after so many queries, even at rest: pairs
/// that were found late are found then.
constexpr int longest_sleep = 256;

/// Least band of a loop over pairs of patches that does little with each.
constexpr int pairs_at_once = 1024;

bool differ(const Points& a, const Points& b, const Workers& workers) {
  std::atomic<bool> result{false};
  workers.parallel_for(static_cast<int>(a.size()), [&](int begin, int end) {
    if (!std::equal(a.data() + begin, a.data() + end, b.data() + begin)) result = true;
  });
  return result;
}

/// By cloth [m].
std::vector<double> thickness_of(const Cloth& cloth) {
  if (cloth.first_points.empty()) return {cloth.thickness};
  std::vector<double> all;
  for (const int first : cloth.first_points) all.push_back(cloth.thickness_at(first));
  return all;
}

}  // namespace

NearPairs::Surface NearPairs::of_grid(const Cloth& cloth, const Tiling::Range& stencils) {
  const auto tiling = std::make_shared<Tiling>(cloth.columns, cloth.rows);
  const auto patches =
      std::make_shared<std::vector<Patch>>(cut_into_patches(*tiling, cloth.columns, cloth.rows));
  return {std::make_shared<SurfaceMesh>(stencils.are_points() ? SurfaceMesh(0, {})
                                                              : SurfaceMesh(cloth)),
          tiling, patches, std::make_shared<NearestDistances>(cloth, tiling, *patches, stencils)};
}

NearPairs::Surface NearPairs::of_mesh(const SurfaceMesh& mesh, const Points& rest,
                                      const std::vector<double>& thickness,
                                      const Tiling::Range& stencils) {
  const auto tiling = std::make_shared<Tiling>(mesh);
  const auto patches = std::make_shared<std::vector<Patch>>(cut_into_patches(*tiling, rest));
  return {std::make_shared<SurfaceMesh>(stencils.are_points() ? SurfaceMesh(0, {}) : mesh), tiling,
          patches,
          std::make_shared<NearestDistances>(mesh, rest, thickness, tiling, *patches, stencils)};
}

NearPairs::NearPairs(const Cloth& cloth, const Tiling::Range& stencils)
    : NearPairs(cloth.is_mesh() ? of_mesh(SurfaceMesh(cloth), cloth.rest_positions,
                                          thickness_of(cloth), stencils)
                                : of_grid(cloth, stencils),
                stencils) {}

NearPairs::NearPairs(const SurfaceMesh& mesh, const Points& rest,
                     const std::vector<double>& thickness, const Tiling::Range& stencils)
    : NearPairs(of_mesh(mesh, rest, thickness, stencils), stencils) {}

NearPairs::NearPairs(const Surface& surface, const Tiling::Range& stencils)
    : of_points_(stencils.are_points()),
      mesh_(surface.mesh),
      tiling_(surface.tiling),
      patches_(surface.patches),
      nearest_(surface.nearest),
      shapes_(tiling_, patches_),
      tracked_(mesh_, nearest_),
      sees_(Patch::side * nearest_->spacing()),
      paired_(TrackedPairs::range * nearest_->max() + sees_),
      margin_(margin_share * nearest_->min_at_rest()) {}

/// Pairs of patches that are near enough, ascending.
std::vector<std::array<int, 2>> NearPairs::near_patches(const std::vector<Box>& boxes,
                                                        const Workers& workers) const {
  // With points alone all contacts on a path are found, however long; paths of surfaces are
  // truncated to the range.
  const double within = paired_ + (of_points_ ? motions_.max() : 0);
  std::vector<Box> wider = boxes;
  for (Box& box : wider) {
    box.min().array() -= within / 2;
    box.max().array() += within / 2;
  }
  const BoxTree tree(wider);
  using Places = std::vector<std::array<int, 2>>;
  const auto bands = workers.gather<Places>(
      static_cast<int>(wider.size()),
      [&](int begin, int end, Places& near) {
        for (int p = begin; p < end; ++p) {
          const auto first = static_cast<std::ptrdiff_t>(near.size());
          near.push_back({p, p});
          tree.visit_overlapping(wider[static_cast<std::size_t>(p)], [&](int q) {
            if (q > p) near.push_back({p, q});
          });
          std::sort(near.begin() + first, near.end());
        }
      },
      Workers::dearest);
  Places near;
  for (const Places& of_band : bands) near.insert(near.end(), of_band.begin(), of_band.end());
  return near;
}

/// Pairs the patches that are near enough; existing pairs are kept.
void NearPairs::pair_patches(const Workers& workers) {
  std::vector<Box> boxes(patches_->size());
  workers.each(static_cast<int>(boxes.size()), [&](int p) {
    const auto patch = static_cast<std::size_t>(p);
    boxes[patch] = around(last_, (*patches_)[patch].points);
  });
  const auto near = near_patches(boxes, workers);
  last_pairs_.swap(patch_pairs_);
  patch_pairs_.resize(near.size());
  workers.each(static_cast<int>(near.size()), [&](int k) {
    const auto place = static_cast<std::size_t>(k);
    const auto& [p, q] = near[place];
    const auto old = std::lower_bound(last_pairs_.begin(), last_pairs_.end(), near[place],
                                      [](const PatchPair& a, const std::array<int, 2>& b) {
                                        return std::array{a.p, a.q} < b;
                                      });
    if (old != last_pairs_.end() && old->p == p && old->q == q) {
      patch_pairs_[place] = std::move(*old);
      return;
    }
    const double apart = std::sqrt(boxes[static_cast<std::size_t>(p)].squaredExteriorDistance(
        boxes[static_cast<std::size_t>(q)]));
    patch_pairs_[place] = {p, q, 0, apart - nearest_->max(), apart};
  });
  paired_nearer_ = 0;
}

/// Computes the approach of patches on straight paths from their present positions.
void NearPairs::bound_motion(const Points& ends, const Workers& workers) {
  motions_.follow(*patches_, last_, ends, workers);
  if (paired_nearer_ + motions_.max() > sees_) pair_patches(workers);
  workers.each(static_cast<int>(patch_pairs_.size()), [&](int k) {
    PatchPair& pair = patch_pairs_[static_cast<std::size_t>(k)];
    pair.step = motions_.between(pair.p, pair.q);
  });
}

void NearPairs::go(const Points& ends, const Workers& workers) {
  workers.each(static_cast<int>(patch_pairs_.size()), [&](int k) {
    PatchPair& pair = patch_pairs_[static_cast<std::size_t>(k)];
    pair.to_touch -= pair.step;
    pair.to_meet -= pair.step;
    for (Listed& of : pair.listed) of.gap -= pair.step;
  });
  paired_nearer_ += motions_.max();
  last_ = ends;
}

/// Accounts for points that are elsewhere than the queries have followed them.
void NearPairs::move_to(const Points& positions, const Workers& workers) {
  if (last_.rows() == 0) {
    last_ = positions;
    pair_patches(workers);
  } else if (differ(last_, positions, workers)) {
    bound_motion(positions, workers);
    go(positions, workers);
  }
}

/// The pairs of patches, with their places, that meet a condition.
template <typename Condition>
std::vector<NearPairs::PatchPair*> NearPairs::select(const Workers& workers,
                                                     const Condition& meets) {
  const auto bands = workers.gather<std::vector<PatchPair*>>(
      static_cast<int>(patch_pairs_.size()),
      [&](int begin, int end, std::vector<PatchPair*>& selected) {
        for (int k = begin; k < end; ++k) {
          PatchPair& pair = patch_pairs_[static_cast<std::size_t>(k)];
          if (meets(pair, k)) selected.push_back(&pair);
        }
      },
      pairs_at_once);
  std::vector<PatchPair*> all;
  for (const auto& selected : bands) all.insert(all.end(), selected.begin(), selected.end());
  return all;
}

/// Updates the tiles of the patches to be measured.
void NearPairs::shape(const std::vector<PatchPair*>& due, const Workers& workers) {
  std::vector<char> is_due(patches_->size(), 0);
  for (const PatchPair* pair : due) {
    for (const int p : {pair->p, pair->q}) is_due[static_cast<std::size_t>(p)] = 1;
  }
  workers.each(static_cast<int>(is_due.size()), [&](int p) {
    if (is_due[static_cast<std::size_t>(p)] != 0) shapes_.update(p, last_);
  });
}

/// Measures pairs of patches, and returns all features that may come within a `floor` [m] on the
/// paths of the last query; none at -infinity.
std::vector<NearPair> NearPairs::measure_all(const std::vector<PatchPair*>& due, double floor,
                                             const Workers& workers, WorkBudget* budget) {
  shape(due, workers);
  const auto bands = workers.gather<Found>(
      static_cast<int>(due.size()),
      [&](int begin, int end, Found& found) {
        for (int k = begin; k < end; ++k) {
          if (budget && budget->is_spent()) break;  // the frame will be taken back
          PatchPair& pair = *due[static_cast<std::size_t>(k)];
          if (of_points_) {
            measure_points(pair);
          } else {
            measure(pair, pair.step + floor, found);
          }
          if (budget) budget->spend(WorkBudget::patches_measured);
        }
      },
      Workers::dearest, Workers::uneven);
  std::vector<SurfacePair> to_track;
  std::vector<NearPair> meet;
  for (const Found& found : bands) {
    to_track.insert(to_track.end(), found.to_track.begin(), found.to_track.end());
    meet.insert(meet.end(), found.meet.begin(), found.meet.end());
  }
  tracked_.add(std::move(to_track), last_, workers);
  return meet;
}

/// Are features within the margin, or on a path to contact?
bool NearPairs::may_touch(const SurfacePair& pair, const Separation& s, const Points& ahead) const {
  return s.distance <= pair.nearest + margin_ || gap_along(s.normal, pair, ahead) <= pair.nearest;
}

/// Adds tracked pairs, by their points and numbers.
void NearPairs::collect_points(const Points& ahead, const Workers& workers) {
  const auto bands = workers.gather<std::vector<NearPair>>(
      tracked_.size(), [&](int begin, int end, std::vector<NearPair>& found) {
        for (int point = begin; point < end; ++point) {
          for (const TrackedPairs::TrackedPair& tracked_pair : tracked_.of(point)) {
            if (!may_touch(tracked_pair.pair, tracked_pair.last, ahead)) continue;
            const auto key = static_cast<std::uint64_t>(point) << 32 |
                             static_cast<std::uint64_t>(tracked_pair.number);
            found.push_back({key, tracked_pair.pair, tracked_pair.last});
          }
        }
      });
  for (const auto& found : bands) near_.insert(near_.end(), found.begin(), found.end());
}

/// Adds listed edges and points, by their keys.
void NearPairs::collect_listed(const Points& ahead, const Workers& workers) {
  const auto bands = workers.gather<std::vector<NearPair>>(
      static_cast<int>(patch_pairs_.size()),
      [&](int begin, int end, std::vector<NearPair>& found) {
        for (int k = begin; k < end; ++k) {
          PatchPair& of = patch_pairs_[static_cast<std::size_t>(k)];
          for (Listed& listed : of.listed) {
            if (listed.gap > of.step + margin_) continue;
            const auto number = static_cast<std::size_t>(listed.number);
            SurfacePair pair = tiling_->pair(listed.a, listed.b, number);
            const Separation s = separation(pair, last_);
            pair.nearest = nearest_->of(listed.a, listed.b, number);
            listed.gap = s.distance - pair.nearest;
            const bool inside = std::count(s.weights.begin(), s.weights.end(), 0.0) == 0;
            if (!inside && !of_points_) continue;
            if (!may_touch(pair, s, ahead)) continue;
            found.push_back({Tiling::key(listed.a, listed.b, number), pair, s});
          }
        }
      },
      Workers::dear, Workers::uneven);
  const auto first = static_cast<std::ptrdiff_t>(near_.size());
  for (const auto& found : bands) near_.insert(near_.end(), found.begin(), found.end());
  std::sort(near_.begin() + first, near_.end(),
            [](const NearPair& a, const NearPair& b) { return a.key < b.key; });
}

const std::vector<NearPair>& NearPairs::approaching(const Points& positions, const Points& ahead,
                                                    const Workers& workers, WorkBudget* budget) {
  move_to(positions, workers);
  const std::int64_t visited = tracked_.track(positions, workers);
  if (budget) budget->spend(visited);
  // Measured are patches that may touch in a step like the last one, and in turn some near ones.
  // With points alone paths are computed first: nothing else would detect these contacts.
  if (of_points_) bound_motion(ahead, workers);
  const int turn = looks_++ % longest_sleep;
  const auto due = select(workers, [&](const PatchPair& pair, int k) {
    const bool has_turn = (turn - k) % longest_sleep == 0 && pair.to_meet < paired_ - sees_;
    return pair.step > pair.to_touch || has_turn;
  });
  measure_all(due, -TileShapes::infinity, workers, budget);
  near_.clear();
  collect_points(ahead, workers);
  collect_listed(ahead, workers);
  return near_;
}

std::vector<NearPair> NearPairs::swept_query(const Points& here, const Points& ends, double floor,
                                             const Workers& workers, WorkBudget* budget) {
  move_to(here, workers);
  bound_motion(ends, workers);
  const auto due = select(
      workers, [&](const PatchPair& pair, int) { return pair.step + floor >= pair.to_meet; });
  return measure_all(due, floor, workers, budget);
}

void NearPairs::forget() {
  last_.resize(0, 3);
  near_.clear();
  patch_pairs_.clear();
  tracked_ = {mesh_, nearest_};
  looks_ = 0;
}

void NearPairs::write(MemoryWriter& memory) const {
  memory.add(last_.rows() > 0);
  if (last_.rows() == 0) return;
  memory.add(last_);
  memory.add(looks_ % longest_sleep);
  memory.add(paired_nearer_);
  tracked_.write(memory);
  memory.add(static_cast<double>(patch_pairs_.size()));
  for (const PatchPair& pair : patch_pairs_) {
    for (const int number : {pair.p, pair.q}) memory.add(number);
    for (const double number : {pair.step, pair.to_touch, pair.to_meet}) memory.add(number);
    memory.add(static_cast<double>(pair.listed.size()));
    for (const Listed& listed : pair.listed) {
      for (const int number : {listed.a, listed.b, listed.number}) memory.add(number);
      memory.add(listed.gap);
    }
  }
}

void NearPairs::read(MemoryReader& memory) {
  forget();
  if (memory.index(2) == 0) return;
  const std::size_t points = tiling_->num_points(), tiles = tiling_->tiles().size(),
                    patches = patches_->size();
  last_ = memory.points(static_cast<Eigen::Index>(points));
  looks_ = memory.index(longest_sleep);
  paired_nearer_ = std::max(0.0, memory.number());
  tracked_.read(memory);
  for (std::size_t left = memory.count(); left > 0; --left) {
    PatchPair pair{memory.index(patches), memory.index(patches)};
    const bool ascends =
        patch_pairs_.empty() ||
        std::pair(patch_pairs_.back().p, patch_pairs_.back().q) < std::pair(pair.p, pair.q);
    if (pair.p > pair.q || !ascends) {
      throw InvalidValue({"memory"}, "patches in another order", "the memory of this cloth");
    }
    for (double* number : {&pair.step, &pair.to_touch, &pair.to_meet}) *number = memory.number();
    for (std::size_t listed = memory.count(); listed > 0; --listed) {
      const int a = memory.index(tiles), b = memory.index(tiles);
      const int number = memory.index(Tiling::count);
      const bool of_points = number == static_cast<int>(Tiling::own_points);
      if (of_points != of_points_ || nearest_->of(a, b, static_cast<std::size_t>(number)) < 0) {
        throw InvalidValue({"memory"}, "features that the cloth lacks", "the memory of this cloth");
      }
      pair.listed.push_back({a, b, number, memory.number()});
    }
    patch_pairs_.push_back(pair);
  }
}

}  // namespace clothsim
