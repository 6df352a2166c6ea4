#include "clothsim/dynamics/implicit_euler.h"

#include "clothsim/dynamics/drag.h"

namespace clothsim {

void ImplicitEuler::step(const Cloth& cloth, const Loads& loads, double h, State& state,
                         const Workers&) {
  const Past past = past_of(cloth, state, h);
  free_step(cloth, loads, h, state);
  solver_.solve(cloth, free_step_weights(cloth, h), state.positions, displacement_, past);
  state.positions += displacement_;
  state.velocities += displacement_ / h;
}

}  // namespace clothsim
