#include "clothsim/dynamics/stretch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "clothsim/dynamics/springs.h"

namespace clothsim {

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

}  // namespace clothsim
