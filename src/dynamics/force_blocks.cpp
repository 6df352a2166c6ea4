#include "clothsim/dynamics/force_blocks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <memory>
#include <type_traits>

#include "clothsim/dynamics/springs.h"
#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"
#include "force_kernels.h"

namespace clothsim {
namespace {

/// Directions whose forces one pass over a block's points sums: those of a classic cloth.
enum { max_terms = 6 };

CLOTHSIM_TARGET_CLONES
void narrow(const double* x, double origin, int count, float* __restrict to) {
  for (int i = 0; i < count; ++i) to[i] = static_cast<float>(x[i] - origin);
}

/// Adds to start * g the first `n` of `force`, less their values `offset` points before.
template <int n, typename Real, typename Start>
[[gnu::always_inline]] inline void sum_of(double g, const Start* start, const Real* const* force,
                                          const int* offset, int count, Real* __restrict total) {
  const auto factor = static_cast<Start>(g);
  for (int i = 0; i < count; ++i) {
    auto sum = static_cast<Real>(start[i] * factor);
    for (int d = 0; d < n; ++d) sum += force[d][i] - force[d][i - offset[d]];
    total[i] = sum;
  }
}

/// The same for an `n` known at run time, `n_max` at most.
template <int n_max = max_terms, typename Real, typename Start>
[[gnu::always_inline]] inline void sum_up_to_six_of(int n, double g, const Start* start,
                                                    const Real* const* force, const int* offset,
                                                    int count, Real* __restrict total) {
  if constexpr (n_max > 0) {
    if (n < n_max) {
      return sum_up_to_six_of<n_max - 1>(n, g, start, force, offset, count, total);
    }
  }
  sum_of<n_max>(g, start, force, offset, count, total);
}

CLOTHSIM_TARGET_CLONES
void sum_up_to_six(int n, double g, const double* start, const double* const* force,
                   const int* offset, int count, double* total) {
  sum_up_to_six_of(n, g, start, force, offset, count, total);
}
CLOTHSIM_TARGET_CLONES
void sum_up_to_six(int n, double g, const double* start, const float* const* force,
                   const int* offset, int count, float* total) {
  sum_up_to_six_of(n, g, start, force, offset, count, total);
}
CLOTHSIM_TARGET_CLONES
void sum_up_to_six(int n, double g, const float* start, const float* const* force,
                   const int* offset, int count, float* total) {
  sum_up_to_six_of(n, g, start, force, offset, count, total);
}

int end_of(const SpringRun& run) { return run.first + run.count; }

/// Clears the gaps between runs, one point after the other: mostly two or three, too few for a call
/// of memset. `force` begins at point `first`.
template <typename Real>
[[gnu::optimize("no-tree-loop-distribute-patterns", "no-tree-vectorize")]] void clear_gaps(
    const SpringRun* run, const SpringRun* end, int first, int to, Real* const force[3]) {
  Real* const x = force[0];
  Real* const y = force[1];
  Real* const z = force[2];
  for (; run + 1 != end && end_of(*run) < to; ++run) {
    const int next = std::min((run + 1)->first, to);
    for (int i = std::max(end_of(*run), first); i < next; ++i) {
      x[i - first] = y[i - first] = z[i - first] = 0;
    }
  }
}

/// Bytes in a cache line. Stores that begin at one are twice as fast as those across two.
constexpr std::size_t line = 64;

template <typename Real>
int padded(int count) {
  constexpr int numbers = line / sizeof(Real);
  return (count + numbers - 1) / numbers * numbers;
}

}  // namespace

template <typename Real>
ForceBlocks<Real>::ForceBlocks(const Cloth& cloth, const Loads& loads, const Points& positions,
                               int begin, int end, const Points* velocities)
    : cloth_(cloth),
      loads_(loads),
      positions_(positions),
      first_(begin),
      end_(end),
      velocities_(is_damped(cloth) ? velocities : nullptr),
      rates_{} {
  group();
  take_points();

  const int kept = padded<Real>(std::min(points_at_once, end - begin));
  Eigen::Index size = line / sizeof(Real);
  for (const Direction& d : directions_) size += 3 * (padded<Real>(d.offset) + kept);
  for (const Cells& cells : cells_) size += 6 * (padded<Real>(cells.reach()) + kept);
  buffer_.resize(size);

  // The forces of springs and cells that begin before `begin`.
  void* aligned = buffer_.data();
  std::size_t bytes = static_cast<std::size_t>(size) * sizeof(Real);
  Real* free = static_cast<Real*>(std::align(line, sizeof(Real), aligned, bytes));
  for (Direction& d : directions_) free = place(d.offset, kept, free, d);
  for (Cells& cells : cells_) free = place(cells.reach(), kept, free, cells);
}

/// Gives an item its arrays, with room for forces `reach` points before the block, which it sets.
template <typename Real>
template <typename Item>
Real* ForceBlocks<Real>::place(int reach, int kept, Real* free, Item& item) {
  constexpr std::size_t arrays = std::extent_v<decltype(item.force)>;
  Real* before[arrays];
  for (std::size_t k = 0; k < arrays; ++k) {
    item.force[k] = free + padded<Real>(reach);
    free = item.force[k] + kept;
    before[k] = item.force[k] - reach;
  }
  fill(item, first_ - reach, reach, before);
  return free;
}

template <typename Real>
void ForceBlocks<Real>::group() {
  directions_.reserve(max_terms);
  if (cloth_.has_bands()) return group_bands();
  for_each_band(cloth_, [&](const SpringBand& band) {
    if (band.begin->stiffness != 0) {
      directions_.push_back({band.begin->offset, nullptr, band.begin, band.end, {}});
    }
  });
}

/// A fabric: the first cells take the bends along their diagonals with them, where these are all of
/// a band.
template <typename Real>
void ForceBlocks<Real>::group_bands() {
  for (const CellBand& band : cloth_.cell_bands) cells_.push_back({&band, {}, {}});
  if (!cells_.empty()) {
    const CellBand& band = *cells_.front().band;
    const std::array<const PairBand*, 2> bends{bends_of_cells(band, band.a + band.b, 0),
                                               bends_of_cells(band, band.b - band.a, band.a)};
    if (bends[0] != nullptr && bends[1] != nullptr) cells_.front().bends = bends;
  }
  for (const PairBand& pairs : cloth_.pairs) {
    const bool is_taken =
        !cells_.empty() && (cells_.front().bends[0] == &pairs || cells_.front().bends[1] == &pairs);
    if (!is_taken) directions_.push_back({pairs.offset, &pairs, nullptr, nullptr, {}});
  }
}

/// The bends along a diagonal that is `offset` points long and begins `lead` points after the first
/// corner. Null where their band has others, or springs.
template <typename Real>
const PairBand* ForceBlocks<Real>::bends_of_cells(const CellBand& cells, int offset,
                                                  int lead) const {
  for (const PairBand& pairs : cloth_.pairs) {
    if (pairs.offset != offset) continue;
    const auto rest = pairs.bend.size() - lead - cells.stiffness.size();
    const bool is_all = pairs.bend.head(lead).isZero(0) && pairs.bend.tail(rest).isZero(0);
    return is_all && pairs.spring.size() == 0 ? &pairs : nullptr;
  }
  return nullptr;
}

/// Positions as Real. In single precision they are relative to a point of the cloth, to keep digits
/// far from the origin.
template <typename Real>
void ForceBlocks<Real>::take_points() {
  if constexpr (std::is_same_v<Real, double>) {
    for (int axis = 0; axis < 3; ++axis) {
      points_[axis] = &positions_(0, axis);
      if (velocities_ != nullptr) rates_[axis] = &(*velocities_)(0, axis);
    }
  } else {
    int farthest = 0;
    for (const Direction& d : directions_) farthest = std::max(farthest, d.offset);
    for (const Cells& cells : cells_) farthest = std::max(farthest, cells.reach());
    const int n = cloth_.num_points();
    const int from = std::max(0, first_ - farthest);
    const int count = std::min(n, end_ + farthest) - from;
    narrowed_.resize((velocities_ != nullptr ? 6 : 3) * count);
    for (int axis = 0; axis < 3; ++axis) {
      Real* const column = narrowed_.data() + axis * count;
      narrow(&positions_(from, axis), positions_(n / 2, axis), count, column);
      points_[axis] = column - from;
      if (velocities_ == nullptr) continue;
      narrow(&(*velocities_)(from, axis), 0, count, column + 3 * count);
      rates_[axis] = column + 3 * count - from;
    }
  }
}

template <typename Real>
void ForceBlocks<Real>::fill(Direction& d, int first, int count, Real* const force[3]) const {
  const int end = first + count;
  int from = 0, to = 0;  // range of springs that exist
  if (d.pairs != nullptr) {
    to = static_cast<int>(d.pairs->bend.size());
  } else {
    while (d.run + 1 != d.end && end_of(*d.run) <= first) ++d.run;
    from = d.run->first;
    to = end_of(*(d.end - 1));
  }
  from = std::clamp(from, first, end);
  to = std::clamp(to, from, end);
  for (int axis = 0; axis < 3; ++axis) {
    std::fill(force[axis], force[axis] + (from - first), Real{0});
    std::fill(force[axis] + (to - first), force[axis] + count, Real{0});
  }
  if (from < to) {
    const int skip = from - first;
    Real* const pulled[3] = {force[0] + skip, force[1] + skip, force[2] + skip};
    pull_between(d, from, to - from, pulled);
  }
  if (d.pairs == nullptr) clear_gaps(d.run, d.end, first, to, force);
}

template <typename Real>
void ForceBlocks<Real>::pull_between(const Direction& d, int from, int count,
                                     Real* const force[3]) const {
  const Columns<Real> p{points_[0] + from, points_[1] + from, points_[2] + from};
  if (d.pairs == nullptr) {
    pull(p, d.offset, count, d.run->rest_length, d.run->stiffness, force[0], force[1], force[2]);
    return;
  }
  const PairBand& pairs = *d.pairs;
  const Pairs some{pairs.spring.size() > 0 ? &pairs.spring[from] : nullptr, &pairs.bend[from],
                   pairs.rest_length, cloth_.internal_damping};
  Columns<Real> v{};
  if (velocities_ != nullptr) v = {rates_[0] + from, rates_[1] + from, rates_[2] + from};
  pull_pairs(some, p, v, d.offset, count, force[0], force[1], force[2]);
}

template <typename Real>
void ForceBlocks<Real>::fill(const Cells& cells, int first, int count, Real* const force[6]) const {
  const CellBand& band = *cells.band;
  const int end = first + count;
  const int from = std::clamp(0, first, end);
  const int to = std::clamp(static_cast<int>(band.stiffness.size()), from, end);
  Real* pulled[6];
  for (int k = 0; k < 6; ++k) {
    std::fill(force[k], force[k] + (from - first), Real{0});
    std::fill(force[k] + (to - first), force[k] + count, Real{0});
    pulled[k] = force[k] + (from - first);
  }
  if (from == to) return;
  CellPulls pulls{band.a, band.b, band.strain, &band.stiffness[from], {}, cloth_.internal_damping};
  if (cells.bends[0] != nullptr) {
    pulls.bends = {&cells.bends[0]->bend[from], &cells.bends[1]->bend[from + band.a]};
  }
  Columns<Real> v{};
  if (velocities_ != nullptr) v = {rates_[0] + from, rates_[1] + from, rates_[2] + from};
  pull_cells(pulls, {points_[0] + from, points_[1] + from, points_[2] + from}, v, to - from,
             pulled);
}

template <typename Real>
bool ForceBlocks<Real>::next() {
  first_ += count_;
  if (first_ >= end_) return false;
  if (count_ > 0) keep_history();
  count_ = std::min(points_at_once, end_ - first_);
  for (Direction& d : directions_) fill(d, first_, count_, d.force);
  for (const Cells& cells : cells_) fill(cells, first_, count_, cells.force);
  return true;
}

template <typename Real>
void ForceBlocks<Real>::keep_history() {
  const auto keep = [&](int reach, const auto& forces) {
    for (Real* force : forces) {
      std::memmove(force - reach, force + count_ - reach,
                   static_cast<std::size_t>(reach) * sizeof(Real));
    }
  };
  for (const Direction& d : directions_) keep(d.offset, d.force);
  for (const Cells& cells : cells_) keep(cells.reach(), cells.force);
}

template <typename Real>
void ForceBlocks<Real>::sum(int axis, Real* forces) const {
  const Real* force[max_terms];
  int offset[max_terms];
  int n = 0;
  bool has_begun = false;
  const auto flush = [&] {
    if (has_begun) {  // the sum so far is the start of the rest
      sum_up_to_six(n, 1, forces, force, offset, count_, forces);
    } else {
      sum_up_to_six(n, loads_.gravity[axis], &cloth_.mass[first_], force, offset, count_, forces);
    }
    has_begun = true;
    n = 0;
  };
  const auto add = [&](const Real* of_first, int to_second) {
    if (n == max_terms) flush();
    force[n] = of_first;
    offset[n++] = to_second;
  };
  for (const Direction& d : directions_) add(d.force[axis], d.offset);
  for (const Cells& cells : cells_) {
    const auto& [a, b] = std::pair(cells.band->a, cells.band->b);
    add(cells.force[axis], a + b);
    add(cells.force[3 + axis] - a, b - a);
  }
  if (n > 0 || !has_begun) flush();
}

template class ForceBlocks<double>;
template class ForceBlocks<float>;

}  // namespace clothsim
