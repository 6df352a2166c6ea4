#include "clothsim/dynamics/forces.h"

#include <algorithm>
#include <cmath>

#include "clothsim/dynamics/target_clones.h"

namespace clothsim {
namespace {

/// Springs handled at a time; their forces stay in the first-level cache.
constexpr int block = 128;

/// Where a run's points begin in each coordinate's column.
struct Columns {
  const double* x;
  const double* y;
  const double* z;
};

/// Force of springs (i, i + offset), i in [0, count), on their first points.
CLOTHSIM_TARGET_CLONES
void spring_block(Columns p, int offset, int count, double rest_length, double stiffness,
                  double* __restrict fx, double* __restrict fy, double* __restrict fz) {
  for (int i = 0; i < count; ++i) {
    const double dx = p.x[i + offset] - p.x[i];
    const double dy = p.y[i + offset] - p.y[i];
    const double dz = p.z[i + offset] - p.z[i];
    const double length = std::sqrt(dx * dx + dy * dy + dz * dz);
    const double s = length > 0 ? stiffness - stiffness * rest_length / length : 0.0;
    fx[i] = s * dx;
    fy[i] = s * dy;
    fz[i] = s * dz;
  }
}

/// The points of a run overlap with those it is joined to, so the two sums are loops of their own.
CLOTHSIM_TARGET_CLONES
void scatter_block(const double* __restrict f, int offset, int count, double* total) {
  for (int i = 0; i < count; ++i) total[i] += f[i];
  for (int i = 0; i < count; ++i) total[i + offset] -= f[i];
}

}  // namespace

void compute_forces(const Cloth& cloth, const Loads& loads, const Points& positions,
                    Points& forces) {
  forces.noalias() = cloth.mass * loads.gravity.transpose();

  double f[3][block];
  for (const SpringRun& run : cloth.springs) {
    if (run.stiffness == 0) continue;
    for (int done = 0; done < run.count; done += block) {
      const int first = run.first + done;
      const int count = std::min(block, run.count - done);
      const Columns p{&positions(first, 0), &positions(first, 1), &positions(first, 2)};
      spring_block(p, run.offset, count, run.rest_length, run.stiffness, f[0], f[1], f[2]);
      for (int axis = 0; axis < 3; ++axis) {
        scatter_block(f[axis], run.offset, count, &forces(first, axis));
      }
    }
  }
}

}  // namespace clothsim
