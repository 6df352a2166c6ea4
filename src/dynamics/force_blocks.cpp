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

namespace clothsim {
namespace {

/// Directions whose forces one pass over a block's points sums: those of a classic cloth.
enum { max_terms = 6 };

/// Added to squared lengths [m^2]: a spring of zero length gets a finite factor, and no force.
template <typename Real>
constexpr Real min_length2 = std::numeric_limits<Real>::min();

/// Addresses of points in each coordinate's column.
template <typename Real>
struct Columns {
  const Real* x;
  const Real* y;
  const Real* z;
};

/// Force of springs (i, i + offset), i in [0, count), on their first points. Square root and
/// division take twice as long as all the rest. Alternatives, an estimate of few bits with Newton's
/// method, or one of single precision with Halley's, take longer, since they need the units that do
/// the rest.
template <typename Real>
[[gnu::always_inline]] inline void pull_of(Columns<Real> p, int offset, int count,
                                           double rest_length, double stiffness,
                                           Real* __restrict fx, Real* __restrict fy,
                                           Real* __restrict fz) {
  const auto k = static_cast<Real>(stiffness);
  const auto tension = static_cast<Real>(stiffness * rest_length);
  for (int i = 0; i < count; ++i) {
    const Real dx = p.x[i + offset] - p.x[i];
    const Real dy = p.y[i + offset] - p.y[i];
    const Real dz = p.z[i + offset] - p.z[i];
    const Real length = std::sqrt(dx * dx + dy * dy + dz * dz + min_length2<Real>);
    const Real s = k - tension / length;
    fx[i] = s * dx;
    fy[i] = s * dy;
    fz[i] = s * dz;
  }
}

CLOTHSIM_TARGET_CLONES
void pull(Columns<double> p, int offset, int count, double rest_length, double stiffness,
          double* fx, double* fy, double* fz) {
  pull_of(p, offset, count, rest_length, stiffness, fx, fy, fz);
}
CLOTHSIM_TARGET_CLONES
void pull(Columns<float> p, int offset, int count, double rest_length, double stiffness, float* fx,
          float* fy, float* fz) {
  pull_of(p, offset, count, rest_length, stiffness, fx, fy, fz);
}

/// Springs and bends between points i and i + offset of a fabric, see PairBand, and their internal
/// damping [s]: of springs, of bends.
struct Pairs {
  const double* spring;
  const double* bend;
  double rest_length;
  std::array<double, 2> damping;
};

/// Forces of pairs (i, i + offset), i in [0, count), on their first points. `v`: velocities where
/// `damped`.
template <bool sprung, bool damped, typename Real>
[[gnu::always_inline]] inline void pull_pairs_of(const Pairs& pairs, Columns<Real> p,
                                                 Columns<Real> v, int offset, int count,
                                                 Real* __restrict fx, Real* __restrict fy,
                                                 Real* __restrict fz) {
  const double* const spring = pairs.spring;
  const double* const bend = pairs.bend;
  const auto rest_length = static_cast<Real>(pairs.rest_length);
  const auto of_springs = static_cast<Real>(pairs.damping[0]);
  const auto of_bends = static_cast<Real>(pairs.damping[1]);
  for (int i = 0; i < count; ++i) {
    const Real dx = p.x[i + offset] - p.x[i];
    const Real dy = p.y[i + offset] - p.y[i];
    const Real dz = p.z[i + offset] - p.z[i];
    const Real ex = damped ? v.x[i + offset] - v.x[i] : Real{0};
    const Real ey = damped ? v.y[i + offset] - v.y[i] : Real{0};
    const Real ez = damped ? v.z[i + offset] - v.z[i] : Real{0};
    const auto w = static_cast<Real>(bend[i]);
    Real s = w;
    if constexpr (sprung) {
      const auto k = static_cast<Real>(spring[i]);
      const Real inverse = 1 / std::sqrt(dx * dx + dy * dy + dz * dz + min_length2<Real>);
      s += k - k * rest_length * inverse;
      if constexpr (damped) {
        const Real rate = (dx * inverse * ex + dy * inverse * ey + dz * inverse * ez) * inverse;
        s += of_springs * k * rate;
      }
    }
    const Real t = of_bends * w;
    fx[i] = damped ? s * dx + t * ex : s * dx;
    fy[i] = damped ? s * dy + t * ey : s * dy;
    fz[i] = damped ? s * dz + t * ez : s * dz;
  }
}

template <typename Real>
[[gnu::always_inline]] inline void pull_any_pairs_of(const Pairs& pairs, Columns<Real> p,
                                                     Columns<Real> v, int offset, int count,
                                                     Real* fx, Real* fy, Real* fz) {
  const bool sprung = pairs.spring != nullptr;
  const bool damped = v.x != nullptr;
  if (sprung && damped) return pull_pairs_of<true, true>(pairs, p, v, offset, count, fx, fy, fz);
  if (sprung) return pull_pairs_of<true, false>(pairs, p, v, offset, count, fx, fy, fz);
  if (damped) return pull_pairs_of<false, true>(pairs, p, v, offset, count, fx, fy, fz);
  pull_pairs_of<false, false>(pairs, p, v, offset, count, fx, fy, fz);
}

CLOTHSIM_TARGET_CLONES
void pull_pairs(const Pairs& pairs, Columns<double> p, Columns<double> v, int offset, int count,
                double* fx, double* fy, double* fz) {
  pull_any_pairs_of(pairs, p, v, offset, count, fx, fy, fz);
}
CLOTHSIM_TARGET_CLONES
void pull_pairs(const Pairs& pairs, Columns<float> p, Columns<float> v, int offset, int count,
                float* fx, float* fy, float* fz) {
  pull_any_pairs_of(pairs, p, v, offset, count, fx, fy, fz);
}

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
  buffer_.resize(size);

  // The forces of springs that begin before `begin`.
  void* aligned = buffer_.data();
  std::size_t bytes = static_cast<std::size_t>(size) * sizeof(Real);
  Real* free = static_cast<Real*>(std::align(line, sizeof(Real), aligned, bytes));
  for (Direction& d : directions_) {
    const int offset = d.offset;
    for (Real*& force : d.force) {
      force = free + padded<Real>(offset);
      free = force + kept;
    }
    Real* const before[3] = {d.force[0] - offset, d.force[1] - offset, d.force[2] - offset};
    fill(d, begin - offset, offset, before);
  }
}

template <typename Real>
void ForceBlocks<Real>::group() {
  directions_.reserve(max_terms);
  for (const PairBand& pairs : cloth_.pairs) {
    directions_.push_back({pairs.offset, &pairs, nullptr, nullptr, {}});
  }
  if (!cloth_.pairs.empty()) return;
  for_each_band(cloth_, [&](const SpringBand& band) {
    if (band.begin->stiffness != 0) {
      directions_.push_back({band.begin->offset, nullptr, band.begin, band.end, {}});
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
    for (const Direction& d : directions_) farthest = std::max(farthest, d.offset);
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
    const int offset = d.offset;
    for (Real* force : d.force) {
      std::memmove(force - offset, force + count_ - offset,
                   static_cast<std::size_t>(offset) * sizeof(Real));
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
  for (const Direction& d : directions_) {
    if (n == max_terms) add();
    force[n] = d.force[axis];
    offset[n++] = d.offset;
  }
  if (n > 0 || !has_begun) add();
}

template class ForceBlocks<double>;
template class ForceBlocks<float>;

}  // namespace clothsim
