#include "clothsim/dynamics/bdf2.h"

#include <algorithm>

#include "clothsim/dynamics/drag.h"
#include "clothsim/model/checks.h"

namespace clothsim {

bool Bdf2::has_history(int i, const State& now) const {
  return now.positions.row(i) == returned_.positions.row(i) &&
         now.velocities.row(i) == returned_.velocities.row(i);
}

void Bdf2::step(const Cloth& cloth, const Loads& loads, double h, State& state, const Workers&) {
  const int n = cloth.num_points();
  const bool has_last = !watch_.changed(cloth, h);
  h_ = h;
  // The step without springs.
  const State start = state;
  if (!has_last) add_fall(cloth, loads, h, state);
  Scalars gain = Scalars::Constant(n, h);  // displacement per change of velocity [s]
  Scalars weights = Scalars::Zero(n);      // inertia against displacement [N/m]
  bool all_have_history = has_last;
  const auto step_point = [&](int i, const Drag& drag) {
    const double e = drag.decay;
    auto x = state.positions.row(i);
    auto v = state.velocities.row(i);
    if (cloth.inv_mass[i] == 0) {
      x += h * v;
      return;
    }
    double time = drag.distance;  // of forces [s]
    if (has_last && has_history(i, state)) {
      gain[i] = 2 * h / 3;
      time *= (3 - e) / 3;
      v = e / 3 * (4 * v - e * last_.velocities.row(i)) + time * loads.gravity.transpose();
      x += (x - last_.positions.row(i)) / 3 + gain[i] * v;
    } else {
      v = e * v + time * loads.gravity.transpose();
      x += h * v;
      all_have_history = false;
    }
    weights[i] = cloth.mass[i] / (gain[i] * time);
  };
  for_each_damping(cloth, 0, n, [&](int begin, int end, double damping) {
    const Drag drag(damping, h);
    for (int i = begin; i < end; ++i) step_point(i, drag);
  });
  const Past past = all_have_history ? past_of(cloth, start.positions, last_.positions, h)
                                     : past_of(cloth, start, h);
  last_ = start;

  // The change by springs.
  solver_.solve(cloth, weights, state.positions, displacement_, past);
  state.positions += displacement_;
  state.velocities.array() += displacement_.array().colwise() / gain.array();
  returned_ = state;
  if (!(max_speed_in_history(cloth) < max_given_speed)) forget();  // read() would refuse it
}

void Bdf2::write(MemoryWriter& memory, const Cloth& cloth) const {
  if (watch_.differs(cloth, h_)) return memory.add(0.0);
  memory.add(h_);
  for (const State* state : {&last_, &returned_}) {
    memory.add(state->positions);
    memory.add(state->velocities);
  }
}

void Bdf2::read(MemoryReader& memory, const Cloth& cloth) {
  watch_ = {};
  h_ = memory.number();
  if (h_ <= 0) return;
  watch_.changed(cloth, h_);
  for (State* state : {&last_, &returned_}) {
    state->positions = memory.points(cloth.num_points());
    state->velocities = memory.points(cloth.num_points());
  }
  const double max_speed = max_speed_in_history(cloth);
  if (max_speed < max_given_speed) return;
  throw InvalidValue({"memory"}, to_text(max_speed) + " m/s in the last step",
                     "numbers below " + to_text(max_given_speed));
}

double Bdf2::max_speed_in_history(const Cloth& cloth) const {
  const Eigen::ArrayXd is_free = (cloth.inv_mass.array() > 0).cast<double>();
  const auto max_speed = [&](const Points& velocities) {
    return (velocities.array().abs().colwise() * is_free).maxCoeff();
  };
  return std::max(max_speed(last_.velocities),
                  max_speed((returned_.positions - last_.positions) / h_));
}

}  // namespace clothsim
