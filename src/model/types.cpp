#include "clothsim/model/types.h"

#include <algorithm>

#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// Square of the longest vector from a point of `from` to that of `to`, of `count` in columns so
/// far apart; null: from the origin.
CLOTHSIM_TARGET_CLONES
double longest_way2(int count, const double* from, const double* to) {
  Lanes lanes = {};
  int i = 0;
  const double *const y = to + count, *const z = y + count;
  for (; i + num_lanes <= count; i += num_lanes) {
    Lanes dx = lanes_at(to + i), dy = lanes_at(y + i), dz = lanes_at(z + i);
    if (from) {
      dx -= lanes_at(from + i);
      dy -= lanes_at(from + count + i);
      dz -= lanes_at(from + 2 * count + i);
    }
    const Lanes way2 = dx * dx + dy * dy + dz * dz;
    lanes = way2 > lanes ? way2 : lanes;
  }
  double longest = 0;
  for (int lane = 0; lane < num_lanes; ++lane) longest = std::max(longest, lanes[lane]);
  for (; i < count; ++i) {
    const double dx = to[i] - (from ? from[i] : 0);
    const double dy = y[i] - (from ? from[count + i] : 0);
    const double dz = z[i] - (from ? from[2 * count + i] : 0);
    longest = std::max(longest, dx * dx + dy * dy + dz * dz);
  }
  return longest;
}

}  // namespace

double longest_row(const Points& vectors) {
  return std::sqrt(longest_way2(static_cast<int>(vectors.rows()), nullptr, vectors.data()));
}

double longest_way(const Points& from, const Points& to) {
  return std::sqrt(longest_way2(static_cast<int>(to.rows()), from.data(), to.data()));
}

}  // namespace clothsim
