#include "clothsim/dynamics/verlet.h"

#include "clothsim/dynamics/drag.h"
#include "clothsim/dynamics/target_clones.h"

namespace clothsim {
namespace {

/// x += v (1 - exp(-c t)) / c, v *= exp(-c t) for free points; pins keep their velocity.
CLOTHSIM_TARGET_CLONES
void drift(int count, double t, double distance, double decay, const double* __restrict inv_mass,
           double* __restrict x, double* __restrict v) {
  for (int i = 0; i < count; ++i) {
    const bool free = inv_mass[i] > 0;
    x[i] += (free ? distance : t) * v[i];
    v[i] *= free ? decay : 1.0;
  }
}

/// v += h f / m.
CLOTHSIM_TARGET_CLONES
void kick(int count, double h, const double* __restrict inv_mass, const double* __restrict f,
          double* __restrict v) {
  for (int i = 0; i < count; ++i) v[i] += h * inv_mass[i] * f[i];
}

void drift(const Cloth& cloth, double t, State& state) {
  const Drag drag(cloth.damping, t);
  for (int axis = 0; axis < 3; ++axis) {
    drift(cloth.num_points(), t, drag.distance, drag.decay, cloth.inv_mass.data(),
          state.positions.col(axis).data(), state.velocities.col(axis).data());
  }
}

}  // namespace

double VelocityVerlet::reach(double damping, double h) {
  const Drag after_kick(damping, h / 2);
  return after_kick.distance / (after_kick.decay * h);
}

void VelocityVerlet::step(const Cloth& cloth, const Loads& loads, double h, State& state) {
  forces_.resize(cloth.num_points(), 3);

  drift(cloth, h / 2, state);
  compute_forces(cloth, loads, state.positions, forces_);
  for (int axis = 0; axis < 3; ++axis) {
    kick(cloth.num_points(), h, cloth.inv_mass.data(), forces_.col(axis).data(),
         state.velocities.col(axis).data());
  }
  drift(cloth, h / 2, state);
}

}  // namespace clothsim
