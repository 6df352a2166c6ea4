#include "clothsim/dynamics/force_blocks.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <memory>

#include "clothsim/dynamics/springs.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// Points in a block: the partial forces of so many fit the second-level cache. Measured; shorter
/// loops lose more than the first level wins.
constexpr int block = 2560;

/// Directions that one pass over a block's points sums.
constexpr int most = 6;

/// Added to squared lengths [m^2]: a spring of no length gets a finite factor, and no force. It
/// changes no length above 1e-142 m.
constexpr double least_length2 = 1e-300;

/// Where points begin in each coordinate's column.
struct Columns {
  const double* x;
  const double* y;
  const double* z;
};

/// Force of springs (i, i + offset), i in [0, count), on their first points. Square root and
/// division take twice as long as all the rest: a start of few bits with Newton's method, or of
/// single precision with Halley's, takes longer, since it needs the units that do the rest.
CLOTHSIM_TARGET_CLONES
void pull(Columns p, int offset, int count, double rest_length, double stiffness,
          double* __restrict fx, double* __restrict fy, double* __restrict fz) {
  for (int i = 0; i < count; ++i) {
    const double dx = p.x[i + offset] - p.x[i];
    const double dy = p.y[i + offset] - p.y[i];
    const double dz = p.z[i + offset] - p.z[i];
    const double length = std::sqrt(dx * dx + dy * dy + dz * dz + least_length2);
    const double s = stiffness - stiffness * rest_length / length;
    fx[i] = s * dx;
    fy[i] = s * dy;
    fz[i] = s * dz;
  }
}

/// Adds to a weight m g the first `n` of `force`, less what they are `offset` points before.
template <int n>
[[gnu::always_inline]] inline void sum_of(double g, const double* __restrict m,
                                          const double* const* force, const int* offset, int count,
                                          double* __restrict total) {
  for (int i = 0; i < count; ++i) {
    double sum = m[i] * g;
    for (int d = 0; d < n; ++d) sum += force[d][i] - force[d][i - offset[d]];
    total[i] = sum;
  }
}

CLOTHSIM_TARGET_CLONES
void sum_up_to_six(int n, double g, const double* m, const double* const* force, const int* offset,
                   int count, double* total) {
  switch (n) {
    case 0:
      return sum_of<0>(g, m, force, offset, count, total);
    case 1:
      return sum_of<1>(g, m, force, offset, count, total);
    case 2:
      return sum_of<2>(g, m, force, offset, count, total);
    case 3:
      return sum_of<3>(g, m, force, offset, count, total);
    case 4:
      return sum_of<4>(g, m, force, offset, count, total);
    case 5:
      return sum_of<5>(g, m, force, offset, count, total);
    default:
      return sum_of<most>(g, m, force, offset, count, total);
  }
}

int end_of(const SpringRun& run) { return run.first + run.count; }

/// Clears what stands between runs, one point after the other: they are two or three mostly, too
/// few for a call of memset. `force` begins at point `first`.
[[gnu::optimize("no-tree-loop-distribute-patterns", "no-tree-vectorize")]] void clear_gaps(
    const SpringRun* run, const SpringRun* end, int first, int to, double* const force[3]) {
  double* const x = force[0];
  double* const y = force[1];
  double* const z = force[2];
  for (; run + 1 != end && end_of(*run) < to; ++run) {
    const int next = std::min((run + 1)->first, to);
    for (int i = std::max(end_of(*run), first); i < next; ++i) {
      x[i - first] = y[i - first] = z[i - first] = 0;
    }
  }
}

/// Numbers in a line of the caches. Stores that begin at one are twice as fast as those across two.
constexpr int line = 8;

int padded(int count) { return (count + line - 1) / line * line; }

}  // namespace

ForceBlocks::ForceBlocks(const Cloth& cloth, const Loads& loads, const Points& positions, int begin,
                         int end)
    : cloth_(cloth), loads_(loads), positions_(positions), first_(begin), end_(end) {
  group();

  const int kept = padded(std::min(block, end - begin));
  Eigen::Index size = line;
  for (const Direction& d : directions_) size += 3 * (padded(d.run->offset) + kept);
  buffer_.resize(size);

  // What springs of the points before `begin` pull.
  void* aligned = buffer_.data();
  std::size_t bytes = static_cast<std::size_t>(size) * sizeof(double);
  double* free =
      static_cast<double*>(std::align(line * sizeof(double), sizeof(double), aligned, bytes));
  for (Direction& d : directions_) {
    const int offset = d.run->offset;
    for (double*& force : d.force) {
      force = free + padded(offset);
      free = force + kept;
    }
    double* const before[3] = {d.force[0] - offset, d.force[1] - offset, d.force[2] - offset};
    fill(d, begin - offset, offset, before);
  }
}

void ForceBlocks::group() {
  directions_.reserve(most);
  for_each_band(cloth_, [&](const SpringBand& band) {
    if (band.begin->stiffness != 0) directions_.push_back({band.begin, band.end, {}});
  });
}

void ForceBlocks::fill(Direction& d, int first, int count, double* const force[3]) const {
  const auto clear = [&](int from, int to) {
    for (int axis = 0; axis < 3; ++axis) {
      std::fill(force[axis] + (from - first), force[axis] + (to - first), 0.0);
    }
  };
  const int end = first + count;
  while (d.run + 1 != d.end && end_of(*d.run) <= first) ++d.run;
  const int from = std::clamp(d.run->first, first, end);
  const int to = std::clamp(end_of(*(d.end - 1)), from, end);

  clear(first, from);
  if (from < to) {
    const int skip = from - first;
    pull({&positions_(from, 0), &positions_(from, 1), &positions_(from, 2)}, d.run->offset,
         to - from, d.run->rest_length, d.run->stiffness, force[0] + skip, force[1] + skip,
         force[2] + skip);
  }
  clear(to, end);

  clear_gaps(d.run, d.end, first, to, force);
}

bool ForceBlocks::next() {
  first_ += count_;
  if (first_ >= end_) return false;
  if (count_ > 0) keep_history();
  count_ = std::min(block, end_ - first_);
  for (Direction& d : directions_) fill(d, first_, count_, d.force);
  return true;
}

void ForceBlocks::keep_history() {
  for (Direction& d : directions_) {
    const int offset = d.run->offset;
    for (double* force : d.force) {
      std::memmove(force - offset, force + count_ - offset,
                   static_cast<std::size_t>(offset) * sizeof(double));
    }
  }
}

void ForceBlocks::sum(int axis, double* forces) const {
  const double* force[most];
  int offset[most];
  int n = 0;
  double g = loads_.gravity[axis];
  const double* start = &cloth_.mass[first_];
  for (const Direction& d : directions_) {
    if (n == most) {  // what is summed so far is the start of the rest
      sum_up_to_six(n, g, start, force, offset, count_, forces);
      g = 1;
      start = forces;
      n = 0;
    }
    force[n] = d.force[axis];
    offset[n++] = d.run->offset;
  }
  sum_up_to_six(n, g, start, force, offset, count_, forces);
}

}  // namespace clothsim
