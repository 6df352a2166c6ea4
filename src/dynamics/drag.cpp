#include "clothsim/dynamics/drag.h"

namespace clothsim {

void coast(const Cloth& cloth, const Loads& loads, double h, State& state) {
  const Drag drag(cloth.damping, h);
  for (int axis = 0; axis < 3; ++axis) {
    const double gained = drag.distance * loads.gravity[axis];
    for (int i = 0; i < cloth.num_points(); ++i) {
      double& v = state.velocities(i, axis);
      if (cloth.inv_mass[i] > 0) v = drag.decay * v + gained;
      state.positions(i, axis) += h * v;
    }
  }
}

Scalars coast_weights(const Cloth& cloth, double h) {
  const double time2 = h * Drag(cloth.damping, h).distance;
  return (cloth.inv_mass.array() > 0).select(cloth.mass.array() / time2, 0);
}

}  // namespace clothsim
