#include "clothsim/dynamics/drag.h"

namespace clothsim {

void add_fall(const Cloth& cloth, const Loads& loads, double h, State& state) {
  if (!loads.acts_alone) return;
  const Drag drag(cloth.damping, h);
  const Vector3 of_gravity = (drag.fall - h * drag.distance) * loads.gravity;
  state.positions += (drag.distance - h * drag.decay) * state.velocities;
  state.positions.rowwise() += of_gravity.transpose();
}

void free_step(const Cloth& cloth, const Loads& loads, double h, State& state) {
  add_fall(cloth, loads, h, state);
  const Drag drag(cloth.damping, h);
  for (int axis = 0; axis < 3; ++axis) {
    const double gained = drag.distance * loads.gravity[axis];
    for (int i = 0; i < cloth.num_points(); ++i) {
      double& v = state.velocities(i, axis);
      if (cloth.inv_mass[i] > 0) {
        v = drag.decay * v + gained;
        if (loads.impulses) v += (*loads.impulses)(i, axis);
      }
      state.positions(i, axis) += h * v;
    }
  }
}

Scalars free_step_weights(const Cloth& cloth, double h) {
  const double time2 = h * Drag(cloth.damping, h).distance;
  return (cloth.inv_mass.array() > 0).select(cloth.mass.array() / time2, 0);
}

}  // namespace clothsim
