#include "clothsim/collision/near_pairs.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <limits>

namespace clothsim {
namespace {

/// Margin, of the least distance at rest: with the slack of neighbours small enough that a moderate
/// bend is proved to keep them apart.
constexpr double margin_share = 0.12;

/// So many sides of a patch more than needed paired patches may be apart.
constexpr double pairing_sides = 0.5;

constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

NearPairs::NearPairs(const Cloth& cloth)
    : mesh_(cloth), nearest_(cloth), patches_(cut_into_patches(cloth, patch_cells)) {
  const Points& x = cloth.rest_positions;
  const double along_row = (x.row(1) - x.row(0)).norm();
  const double along_column = (x.row(cloth.columns) - x.row(0)).norm();
  spacing_ = std::min(along_row, along_column);
  // A point and the long side of a triangle; two diagonals side by side are as far apart.
  least_rest_distance_ = along_row * along_column / std::hypot(along_row, along_column);
  contact_ = 2 * cloth.thickness;
  margin_ = margin_share * least_rest_distance_;
  bounds_.resize(static_cast<std::size_t>(mesh_.num_cells()));
  is_bounded_.resize(bounds_.size());
}

/// Calls body(pair, scratch) for all patch pairs; those of a thread come after each other. Then
/// finish(scratch).
template <typename Body, typename Finish>
void NearPairs::share_patch_pairs(const Workers& workers, const Body& body, const Finish& finish) {
  scratches_.resize(static_cast<std::size_t>(workers.threads()));
  for (Scratch& scratch : scratches_) scratch.band = -1;
  std::atomic<std::size_t> used{0};
  constexpr int least = 64;
  workers.share(
      static_cast<int>(patch_pairs_.size()),
      [&](int begin, int end) {
        Scratch& scratch = scratches_[used++];
        scratch.band = begin;
        for (int k = begin; k < end; ++k) body(patch_pairs_[static_cast<std::size_t>(k)], scratch);
        finish(scratch);
      },
      least);
}

const std::vector<NearPair>& NearPairs::approaching(const Cloth& cloth, const Points& positions,
                                                    const Points& ahead, const Workers& workers) {
  advance(cloth, positions, workers);
  motions_.follow(patches_, positions, ahead, workers);
  const auto wake_pair = [&](PatchPair& pair, Scratch& scratch) {
    const double closing = motions_.between(pair.p, pair.q);
    const double most = std::clamp(closing, least_margin(), margin_);
    if (pair.least_wake - pair.moved > most) return;
    wake(
        positions, pair, [most](double) { return most; }, scratch);
  };
  share_patch_pairs(workers, wake_pair, [&](Scratch& s) { measure_awake(positions, s); });
  return collect();
}

const std::vector<NearPair>& NearPairs::within(const Cloth& cloth, const Points& positions,
                                               double distance, const Workers& workers) {
  assert(distance <= reach());
  advance(cloth, positions, workers);
  const auto wake_pair = [&](PatchPair& pair, Scratch& scratch) {
    if (pair.least_wake - pair.moved + pair.least_nearest > distance) return;
    wake(
        positions, pair, [distance](double nearest) { return distance - nearest; }, scratch);
  };
  share_patch_pairs(workers, wake_pair, [&](Scratch& s) { measure_awake(positions, s); });
  return collect();
}

/// What all threads have found, in order.
const std::vector<NearPair>& NearPairs::collect() {
  std::vector<Scratch*> order;
  for (Scratch& scratch : scratches_) order.push_back(&scratch);
  std::sort(order.begin(), order.end(),
            [](const Scratch* a, const Scratch* b) { return a->band < b->band; });
  near_.clear();
  for (Scratch* scratch : order) {
    if (near_.empty()) {
      near_.swap(scratch->near);
    } else {
      near_.insert(near_.end(), scratch->near.begin(), scratch->near.end());
    }
    scratch->near.clear();
  }
  return near_;
}

/// Measures the candidates whose gap may be within `reach` of their nearest distance.
template <typename Reach>
void NearPairs::wake(const Points& positions, PatchPair& pair, const Reach& reach,
                     Scratch& scratch) const {
  pair.least_wake = infinity;
  for (std::size_t k = 0; k < pair.candidates.size(); ++k) {
    const SurfacePair& features = pair.candidates[k].pair;
    const double gap = reach(features.nearest);
    if (pair.wake_at[k] - pair.moved > gap) {
      pair.least_wake = std::min(pair.least_wake, pair.wake_at[k]);
      continue;
    }
    scratch.awake.push_back({&pair, k, gap});
    scratch.distances.add(features);
    if (scratch.distances.size() == Distances::capacity) measure_awake(positions, scratch);
  }
}

/// Keeps those that are as near as they were woken for. All go to sleep again.
void NearPairs::measure_awake(const Points& positions, Scratch& scratch) const {
  scratch.distances.measure(positions);
  for (std::size_t i = 0; i < scratch.awake.size(); ++i) {
    const auto& [pair, number, reach] = scratch.awake[i];
    const Candidate& candidate = pair->candidates[number];
    double gap = scratch.distances[i] - candidate.pair.nearest;
    if (gap <= reach) {
      const Separation s = separation(candidate.pair, positions);
      gap = s.distance - candidate.pair.nearest;
      if (gap <= reach) scratch.near.push_back({candidate.key, candidate.pair, s});
    }
    pair->wake_at[number] = pair->moved + gap;
    pair->least_wake = std::min(pair->least_wake, pair->wake_at[number]);
  }
  scratch.awake.clear();
  scratch.distances.clear();
}

/// Brings patch pairs and candidates up to date.
void NearPairs::advance(const Cloth& cloth, const Points& positions, const Workers& workers) {
  const auto nothing = [](Scratch&) {};
  const double most_spread = pairing_sides * patch_cells * spacing_;
  const double reach = contact_ + margin_ + most_spread;
  if (last_.rows() == 0) {
    pair_patches(positions, reach);
  } else if (last_ != positions) {
    motions_.follow(patches_, last_, positions, workers);
    const auto move = [&](PatchPair& pair, Scratch&) {
      pair.moved += motions_.between(pair.p, pair.q);
    };
    share_patch_pairs(workers, move, nothing);
    Points ways = positions - paired_at_;
    const Eigen::RowVector3d common = ways.colwise().mean();
    ways.rowwise() -= common;
    const double spread = std::sqrt(ways.rowwise().squaredNorm().maxCoeff());
    if (2 * spread > most_spread) pair_patches(positions, reach);
  } else {
    return;
  }
  last_ = positions;
  const auto look = [&](PatchPair& pair, Scratch&) {
    pair.is_sought = pair.moved >= pair.allowance && is_to_be_sought(positions, pair);
  };
  share_patch_pairs(workers, look, nothing);
  bound_cells(cloth, positions, workers);
  const auto seek_pair = [&](PatchPair& pair, Scratch& scratch) {
    if (pair.is_sought) seek(positions, pair, scratch);
  };
  share_patch_pairs(workers, seek_pair, [&](Scratch& s) { take_candidates(positions, s); });
}

}  // namespace clothsim
