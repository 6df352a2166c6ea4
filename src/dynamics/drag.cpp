#include "clothsim/dynamics/drag.h"

namespace clothsim {

Scalars impulses_as_forces(const Cloth& cloth, double h) {
  Scalars factors(cloth.num_points());
  for_each_damping(cloth, 0, cloth.num_points(), [&](int begin, int end, double damping) {
    factors.segment(begin, end - begin).setConstant(h / Drag(damping, h).distance);
  });
  return factors;
}

void add_fall(const Cloth& cloth, const Loads& loads, double h, State& state) {
  if (!loads.acts_alone) return;
  for_each_damping(cloth, 0, cloth.num_points(), [&](int begin, int end, double damping) {
    const Drag drag(damping, h);
    const Vector3 of_gravity = (drag.fall - h * drag.distance) * loads.gravity;
    auto positions = state.positions.middleRows(begin, end - begin);
    positions += (drag.distance - h * drag.decay) * state.velocities.middleRows(begin, end - begin);
    positions.rowwise() += of_gravity.transpose();
  });
}

void free_step(const Cloth& cloth, const Loads& loads, double h, State& state) {
  add_fall(cloth, loads, h, state);
  for_each_damping(cloth, 0, cloth.num_points(), [&](int begin, int end, double damping) {
    const Drag drag(damping, h);
    for (int axis = 0; axis < 3; ++axis) {
      const double gained = drag.distance * loads.gravity[axis];
      for (int i = begin; i < end; ++i) {
        double& v = state.velocities(i, axis);
        if (cloth.inv_mass[i] > 0) {
          v = drag.decay * v + gained;
          if (loads.impulses) v += (*loads.impulses)(i, axis);
        }
        state.positions(i, axis) += h * v;
      }
    }
  });
}

Scalars free_step_weights(const Cloth& cloth, double h) {
  Scalars weights = Scalars::Zero(cloth.num_points());
  for_each_damping(cloth, 0, cloth.num_points(), [&](int begin, int end, double damping) {
    const double time2 = h * Drag(damping, h).distance;
    for (int i = begin; i < end; ++i) {
      if (cloth.inv_mass[i] > 0) weights[i] = cloth.mass[i] / time2;
    }
  });
  return weights;
}

}  // namespace clothsim
