#include "clothsim/dynamics/symplectic_euler.h"

#include "clothsim/dynamics/drag.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// v = v decay + time f / m, x += h v; pins keep their velocity.
CLOTHSIM_TARGET_CLONES
void kick_and_drift(int count, double h, double time, double decay,
                    const double* __restrict inv_mass, const double* __restrict f,
                    double* __restrict x, double* __restrict v) {
  for (int i = 0; i < count; ++i) {
    v[i] = (inv_mass[i] > 0 ? decay : 1.0) * v[i] + time * inv_mass[i] * f[i];
    x[i] += h * v[i];
  }
}

}  // namespace

void SymplecticEuler::step(const Cloth& cloth, const Loads& loads, double h, State& state,
                           const Workers& workers) {
  forces_.resize(cloth.num_points(), 3);
  compute_forces(cloth, loads, state.positions, forces_, workers, &state.velocities);

  add_fall(cloth, loads, h, state);
  workers.parallel_for(cloth.num_points(), [&](int begin, int end) {
    for_each_damping(cloth, begin, end, [&](int first, int next, double damping) {
      const Drag drag(damping, h);
      for (int axis = 0; axis < 3; ++axis) {
        kick_and_drift(next - first, h, drag.distance, drag.decay, &cloth.inv_mass[first],
                       &forces_(first, axis), &state.positions(first, axis),
                       &state.velocities(first, axis));
      }
    });
  });
}

}  // namespace clothsim
