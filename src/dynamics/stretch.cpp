#include "clothsim/dynamics/stretch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/target_clones.h"

namespace clothsim {
namespace {

/// Largest squared length of springs (i, i + offset), i in [0, count).
CLOTHSIM_TARGET_CLONES
double longest_squared(const double* x, const double* y, const double* z, int offset, int count) {
  constexpr int lanes = 8;  // maxima of their own, so that the loop vectorises
  double longest[lanes] = {};
  int i = 0;
  for (; i + lanes <= count; i += lanes) {
    for (int lane = 0; lane < lanes; ++lane) {
      const int a = i + lane;
      const double dx = x[a + offset] - x[a];
      const double dy = y[a + offset] - y[a];
      const double dz = z[a + offset] - z[a];
      const double length2 = dx * dx + dy * dy + dz * dz;
      longest[lane] = length2 > longest[lane] ? length2 : longest[lane];
    }
  }
  for (; i < count; ++i) {
    const double dx = x[i + offset] - x[i];
    const double dy = y[i + offset] - y[i];
    const double dz = z[i + offset] - z[i];
    longest[0] = std::max(longest[0], dx * dx + dy * dy + dz * dz);
  }
  return *std::max_element(longest, longest + lanes);
}

}  // namespace

Stretch measure_stretch(const Cloth& cloth, const Points& positions) {
  const int count = cloth.num_springs();
  if (count == 0) return {};

  Stretch stretch{-std::numeric_limits<double>::infinity(), 0};
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
  for (const SpringRun& run : cloth.springs) {
    const double length2 = longest_squared(&positions(run.first, 0), &positions(run.first, 1),
                                           &positions(run.first, 2), run.offset, run.count);
    worst = std::max(worst, std::sqrt(length2) / run.rest_length - 1);
  }
  return worst;
}

}  // namespace clothsim
