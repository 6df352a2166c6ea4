#include "clothsim/dynamics/energy.h"

#include <cmath>

#include "clothsim/dynamics/bends.h"
#include "clothsim/dynamics/cells.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/triangle_forces.h"
#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// Sum of m v^2 over the free of `count` points.
CLOTHSIM_TARGET_CLONES
double mass_by_speed2(const double* mass, const double* inv_mass, const double* x, const double* y,
                      const double* z, int count) {
  Half sums[2] = {};
  int i = 0;
  for (; i + num_lanes <= count; i += num_lanes) {
    for (int half = 0; half < 2; ++half) {
      const int k = i + half * half_size;
      const Half &vx = half_at(x + k), &vy = half_at(y + k), &vz = half_at(z + k);
      const Half energy = half_at(mass + k) * (vx * vx + vy * vy + vz * vz);
      sums[half] += half_at(inv_mass + k) > 0 ? energy : Half{};
    }
  }
  double sum = 0;
  for (; i < count; ++i) {
    if (inv_mass[i] > 0) sum += mass[i] * (x[i] * x[i] + y[i] * y[i] + z[i] * z[i]);
  }
  add_lanes(sums, sum);
  return sum;
}

}  // namespace

double kinetic_energy(const Cloth& cloth, const State& state) {
  const Points& v = state.velocities;
  return mass_by_speed2(cloth.mass.data(), cloth.inv_mass.data(), &v(0, 0), &v(0, 1), &v(0, 2),
                        cloth.num_points()) /
         2;
}

double elastic_energy(const Cloth& cloth, const Points& positions) {
  double energy = 0;
  if (cloth.is_mesh()) {
    energy = membrane_energy(cloth, positions);
  } else {
    for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
      const double stretch = (positions.row(b) - positions.row(a)).norm() - run.rest_length;
      energy += run.stiffness * stretch * stretch / 2;
    });
  }
  for_each_cell(cloth, [&](const Cell& cell) {
    const double strain = cell.value(positions);
    energy += cell.stiffness * strain * strain / 2;
  });
  for_each_bend(cloth, [&](const auto& bend) {
    energy += bend.stiffness * bend.deviation(positions).squaredNorm() / 2;
  });
  return energy;
}

double gravitational_energy(const Cloth& cloth, const Vector3& gravity, const Points& positions) {
  const Scalars height = -(positions * gravity);
  return (cloth.inv_mass.array() > 0).select(cloth.mass.array() * height.array(), 0).sum();
}

double rms_velocity(const State& state) {
  return std::sqrt(state.velocities.squaredNorm() / static_cast<double>(state.velocities.rows()));
}

}  // namespace clothsim
