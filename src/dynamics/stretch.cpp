#include "clothsim/dynamics/stretch.h"

#include <algorithm>
#include <cmath>

#include "clothsim/dynamics/springs.h"
#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// Squared lengths of springs (i, i + offset), i in [0, count).
CLOTHSIM_TARGET_CLONES
void square_lengths(const double* x, const double* y, const double* z, int offset, int count,
                    double* __restrict length2) {
  for (int i = 0; i < count; ++i) {
    const double dx = x[i + offset] - x[i];
    const double dy = y[i + offset] - y[i];
    const double dz = z[i + offset] - z[i];
    length2[i] = dx * dx + dy * dy + dz * dz;
  }
}

CLOTHSIM_TARGET_CLONES
double largest_of(const double* values, int count) {
  Half even[2] = {};  // two, since a maximum takes longer than a load
  Half odd[2] = {};
  int i = 0;
  for (; i + 2 * num_lanes <= count; i += 2 * num_lanes) {
    for (int half = 0; half < 2; ++half) {
      const Half& a = half_at(values + i + half * half_size);
      const Half& b = half_at(values + i + num_lanes + half * half_size);
      even[half] = a > even[half] ? a : even[half];
      odd[half] = b > odd[half] ? b : odd[half];
    }
  }
  double largest = 0;
  for (; i < count; ++i) largest = std::max(largest, values[i]);
  take_largest(even, largest);
  take_largest(odd, largest);
  return largest;
}

}  // namespace

Stretch measure_stretch(const Cloth& cloth, const Points& positions) {
  const int count = cloth.num_springs();
  if (count == 0) return {};

  Stretch stretch{-infinity, 0};
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const double s = (positions.row(b) - positions.row(a)).norm() / run.rest_length - 1;
    stretch.worst = std::max(stretch.worst, s);
    stretch.mean += s / count;
  });
  return stretch;
}

double worst_stretch(const Cloth& cloth, const Points& positions) {
  if (cloth.springs.empty()) return 0;
  double worst = -1;
  Scalars length2(cloth.num_points());
  for_each_band(cloth, [&](const SpringBand& band) {
    const int a = band.first();
    square_lengths(&positions(a, 0), &positions(a, 1), &positions(a, 2), band.begin->offset,
                   band.count(), length2.data());
    band.for_each_gap([&](int from, int to) { length2.segment(from, to - from).setZero(); });
    const double longest = std::sqrt(largest_of(length2.data(), band.count()));
    worst = std::max(worst, longest / band.begin->rest_length - 1);
  });
  return worst;
}

double worst_violation(const Cloth& cloth, const Points& positions, double worst) {
  if (!cloth.strain_limit) return 0;
  if (cloth.strain_limits.empty()) return std::max(worst - *cloth.strain_limit, 0.0);
  double violation = 0;
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const double longest = 1 + cloth.strain_limit_at(a).value_or(infinity);
    const double length = (row(positions, b) - row(positions, a)).norm();
    violation = std::max(violation, length / run.rest_length - longest);
  });
  return violation;
}

}  // namespace clothsim
