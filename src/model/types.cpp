#include "clothsim/model/types.h"

#include <algorithm>
#include <cmath>

#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// Square of the longest vector from a point of `from` to the same point of `to`, less `common`.
/// `count`: points, and the distance between columns. `from` null: the origin.
CLOTHSIM_TARGET_CLONES
double longest_squared(int count, const double* from, const double* to, const double* common) {
  Half lanes[2] = {};
  int i = 0;
  const double *const y = to + count, *const z = y + count;
  for (; i + num_lanes <= count; i += num_lanes) {
    for (int half = 0; half < 2; ++half) {
      const int k = i + half * half_size;
      Half dx = half_at(to + k) - common[0], dy = half_at(y + k) - common[1];
      Half dz = half_at(z + k) - common[2];
      if (from) {
        dx -= half_at(from + k);
        dy -= half_at(from + count + k);
        dz -= half_at(from + 2 * count + k);
      }
      const Half length2 = dx * dx + dy * dy + dz * dz;
      lanes[half] = length2 > lanes[half] ? length2 : lanes[half];
    }
  }
  double longest = 0;
  take_largest(lanes, longest);
  for (; i < count; ++i) {
    const double dx = to[i] - common[0] - (from ? from[i] : 0);
    const double dy = y[i] - common[1] - (from ? from[count + i] : 0);
    const double dz = z[i] - common[2] - (from ? from[2 * count + i] : 0);
    longest = std::max(longest, dx * dx + dy * dy + dz * dz);
  }
  return longest;
}

double longest(const double* from, const Points& to, const Vector3& common) {
  return std::sqrt(longest_squared(static_cast<int>(to.rows()), from, to.data(), common.data()));
}

/// The mean; zero for no vectors.
Vector3 mean(const Points& vectors) {
  if (vectors.rows() == 0) return Vector3::Zero();
  return vectors.colwise().mean().transpose();
}

}  // namespace

double longest_row(const Points& vectors) { return longest(nullptr, vectors, Vector3::Zero()); }

double farthest_from(const Vector3& origin, const Points& points) {
  return std::sqrt((points.rowwise() - origin.transpose()).rowwise().squaredNorm().maxCoeff());
}

double longest_displacement(const Points& from, const Points& to) {
  return longest(from.data(), to, Vector3::Zero());
}

double longest_beyond_mean(const Points& vectors) {
  return longest(nullptr, vectors, mean(vectors));
}

double longest_beyond_mean(const Points& from, const Points& to) {
  return longest(from.data(), to, mean(to) - mean(from));
}

}  // namespace clothsim
