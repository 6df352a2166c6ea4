#include "clothsim/constraints/changed_points.h"

#include <algorithm>
#include <cmath>

#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

CLOTHSIM_TARGET_CLONES
void find_changed(int begin, int end, Eigen::Index count, double min_change,
                  const double* __restrict v, double* __restrict seen,
                  std::int64_t* __restrict marked, std::int64_t* __restrict changed) {
  const double *const vx = v, *const vy = v + count, *const vz = v + 2 * count;
  double *const sx = seen, *const sy = seen + count, *const sz = seen + 2 * count;
  for (Eigen::Index i = begin; i < end; ++i) {
    const bool differs = (std::abs(vx[i] - sx[i]) > min_change) |
                         (std::abs(vy[i] - sy[i]) > min_change) |
                         (std::abs(vz[i] - sz[i]) > min_change);
    const std::int64_t is_changed = marked[i] | std::int64_t{differs};
    sx[i] = is_changed ? vx[i] : sx[i];
    sy[i] = is_changed ? vy[i] : sy[i];
    sz[i] = is_changed ? vz[i] : sz[i];
    changed[i] = is_changed;
    marked[i] = 0;
  }
}

}  // namespace

void ChangedPoints::mark_all(int count) {
  if (seen_.rows() != count) seen_.setZero(count, 3);
  marked_.assign(static_cast<std::size_t>(count), 1);
  changed_.resize(marked_.size());
}

void ChangedPoints::look(int part, const Points& velocities, double min_change) {
  const auto count = static_cast<int>(velocities.rows());
  const int begin = part * part_size;
  find_changed(begin, std::min(begin + part_size, count), count, min_change, velocities.data(),
               seen_.data(), marked_.data(), changed_.data());
}

}  // namespace clothsim
