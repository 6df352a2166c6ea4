#include "clothsim/dynamics/verlet.h"

#include "clothsim/dynamics/drag.h"
#include "clothsim/dynamics/force_blocks.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// Half a step of drift: x = from + v (1 - exp(-c t)) / c for free points, v t for pins.
CLOTHSIM_TARGET_CLONES
void drift(int count, double t, double distance, const double* __restrict inv_mass,
           const double* __restrict v, const double* __restrict from, double* __restrict x) {
  for (int i = 0; i < count; ++i) x[i] = from[i] + (inv_mass[i] > 0 ? distance : t) * v[i];
}

/// What that drift does to velocities, v *= exp(-c t), the kick v += h f / m, the second drift.
CLOTHSIM_TARGET_CLONES
void kick_and_drift(int count, double h, double distance, double decay,
                    const double* __restrict inv_mass, const double* __restrict f,
                    const double* __restrict middle, double* __restrict x, double* __restrict v) {
  for (int i = 0; i < count; ++i) {
    const bool free = inv_mass[i] > 0;
    const double loss = free ? decay : 1.0;
    const double kicked = loss * v[i] + h * inv_mass[i] * f[i];
    x[i] = middle[i] + (free ? distance : h / 2) * kicked;
    v[i] = loss * kicked;
  }
}

}  // namespace

double VelocityVerlet::reach(double damping, double h) {
  const Drag after_kick(damping, h / 2);
  return after_kick.distance / (after_kick.decay * h);
}

void VelocityVerlet::step(const Cloth& cloth, const Loads& loads, double h, State& state,
                          const Workers& workers) {
  const Drag drag(cloth.damping, h / 2);
  const int n = cloth.num_points();
  middle_.resize(n, 3);
  forces_.resize(n, 3);

  workers.share(n, [&](int begin, int end) {
    for (int axis = 0; axis < 3; ++axis) {
      drift(end - begin, h / 2, drag.distance, &cloth.inv_mass[begin],
            &state.velocities(begin, axis), &state.positions(begin, axis), &middle_(begin, axis));
    }
  });
  workers.share(n, [&](int begin, int end) {
    for (ForceBlocks blocks(cloth, loads, middle_, begin, end); blocks.next();) {
      const int i = blocks.first();
      for (int axis = 0; axis < 3; ++axis) {
        double* f = &forces_(i, axis);
        blocks.sum(axis, f);
        kick_and_drift(blocks.count(), h, drag.distance, drag.decay, &cloth.inv_mass[i], f,
                       &middle_(i, axis), &state.positions(i, axis), &state.velocities(i, axis));
      }
    }
  });
}

}  // namespace clothsim
