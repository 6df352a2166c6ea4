#include "clothsim/dynamics/energy.h"

#include <cmath>

#include "clothsim/dynamics/springs.h"

namespace clothsim {

double kinetic_energy(const Cloth& cloth, const State& state) {
  const Scalars speed2 = state.velocities.rowwise().squaredNorm();
  return (cloth.inv_mass.array() > 0).select(cloth.mass.array() * speed2.array(), 0).sum() / 2;
}

double elastic_energy(const Cloth& cloth, const Points& positions) {
  double energy = 0;
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const double stretch = (positions.row(b) - positions.row(a)).norm() - run.rest_length;
    energy += run.stiffness * stretch * stretch / 2;
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
