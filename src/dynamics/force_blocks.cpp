#include "clothsim/dynamics/force_blocks.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstring>
#include <memory>
#include <type_traits>

#include "clothsim/dynamics/springs.h"
#include "clothsim/model/lanes.h"
#include "force_kernels.h"

namespace clothsim {

using namespace force_kernels;

namespace {

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
constexpr std::size_t line = sizeof(Lanes);

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
      by_stencil_(velocities_ != nullptr && cloth.internal_damping[1] > 0),
      rates_{} {
  group();
  take_points();

  const int kept = padded<Real>(std::min(points_at_once, end - begin));
  Eigen::Index size = line / sizeof(Real);
  for (const Direction& d : directions_) size += 3 * (padded<Real>(d.history) + kept);
  buffer_.resize(size);

  // The forces of springs and bends that begin before `begin`.
  void* aligned = buffer_.data();
  std::size_t bytes = static_cast<std::size_t>(size) * sizeof(Real);
  Real* free = static_cast<Real*>(std::align(line, sizeof(Real), aligned, bytes));
  for (Direction& d : directions_) {
    const int history = d.history;
    for (Real*& force : d.force) {
      force = free + padded<Real>(history);
      free = force + kept;
    }
    Real* const before[3] = {d.force[0] - history, d.force[1] - history, d.force[2] - history};
    fill(d, begin - history, history, before);
  }
}

template <typename Real>
void ForceBlocks<Real>::group() {
  directions_.reserve(max_terms);
  for (const PairBand& pairs : cloth_.pairs) {
    if (by_stencil_ && pairs.spring.size() == 0) continue;
    directions_.push_back({pairs.offset, &pairs, nullptr, nullptr, nullptr, {}});
  }
  if (by_stencil_) {
    assert(cloth_.bend_bands.size() <= max_bends);
    for (const BendBand& bends : cloth_.bend_bands) {
      directions_.push_back({bends.a + bends.b, nullptr, &bends, nullptr, nullptr, {}});
    }
  }
  if (!cloth_.pairs.empty()) return;
  for_each_band(cloth_, [&](const SpringBand& band) {
    if (band.begin->stiffness != 0) {
      directions_.push_back({band.begin->offset, nullptr, nullptr, band.begin, band.end, {}});
    }
  });
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
    for (const Direction& d : directions_) farthest = std::max(farthest, d.history);
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

/// The pulls G of the stencils that begin at points [first, first + count).
template <typename Real>
void ForceBlocks<Real>::fill_bends(const BendBand& bends, int first, int count,
                                   Real* const to[3]) const {
  const int from = std::clamp(0, first, first + count);
  const int end = std::clamp(static_cast<int>(bends.stiffness.size()), from, first + count);
  for (int axis = 0; axis < 3; ++axis) {
    std::fill(to[axis], to[axis] + (from - first), Real{0});
    std::fill(to[axis] + (end - first), to[axis] + count, Real{0});
  }
  if (from == end) return;
  const Stencils stencils{&bends.stiffness[from], bends.a, bends.b, cloth_.internal_damping[1]};
  const Columns<Real> p{points_[0] + from, points_[1] + from, points_[2] + from};
  const Columns<Real> v{rates_[0] + from, rates_[1] + from, rates_[2] + from};
  const int skip = from - first;
  bend(stencils, p, v, end - from, to[0] + skip, to[1] + skip, to[2] + skip);
}

template <typename Real>
void ForceBlocks<Real>::fill(Direction& d, int first, int count, Real* const force[3]) const {
  if (d.bends != nullptr) return fill_bends(*d.bends, first, count, force);
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
    pull(p, d.run->offset, count, d.run->rest_length, d.run->stiffness, force[0], force[1],
         force[2]);
    return;
  }
  const PairBand& pairs = *d.pairs;
  const Pairs some{pairs.spring.size() > 0 ? &pairs.spring[from] : nullptr,
                   by_stencil_ ? nullptr : &pairs.bend[from], pairs.rest_length,
                   cloth_.internal_damping[0]};
  Columns<Real> v{};
  if (velocities_ != nullptr) v = {rates_[0] + from, rates_[1] + from, rates_[2] + from};
  pull_pairs(some, p, v, pairs.offset, count, force[0], force[1], force[2]);
}

template <typename Real>
bool ForceBlocks<Real>::next() {
  first_ += count_;
  if (first_ >= end_) return false;
  if (count_ > 0) keep_history();
  count_ = std::min(points_at_once, end_ - first_);
  for (Direction& d : directions_) fill(d, first_, count_, d.force);
  return true;
}

template <typename Real>
void ForceBlocks<Real>::keep_history() {
  for (Direction& d : directions_) {
    const int history = d.history;
    for (Real* force : d.force) {
      std::memmove(force - history, force + count_ - history,
                   static_cast<std::size_t>(history) * sizeof(Real));
    }
  }
}

template <typename Real>
void ForceBlocks<Real>::sum(int axis, Real* forces) const {
  const Real* force[max_terms];
  int offset[max_terms];
  int n = 0;
  bool has_begun = false;
  const auto add = [&] {
    if (has_begun) {  // the sum so far is the start of the rest
      sum_up_to_six(n, 1, forces, force, offset, count_, forces);
    } else {
      sum_up_to_six(n, loads_.gravity[axis], &cloth_.mass[first_], force, offset, count_, forces);
    }
    has_begun = true;
    n = 0;
  };
  Pulls<Real> pulls;
  int bends = 0;
  for (const Direction& d : directions_) {
    if (d.bends != nullptr) {
      pulls.of[bends] = d.force[axis];
      pulls.a[bends] = d.bends->a;
      pulls.b[bends++] = d.bends->b;
      continue;
    }
    if (n == max_terms) add();
    force[n] = d.force[axis];
    offset[n++] = d.history;
  }
  if (n > 0 || !has_begun) add();
  if (bends > 0) add_bends(bends, pulls, count_, forces);
}

template class ForceBlocks<double>;
template class ForceBlocks<float>;

}  // namespace clothsim
