#include "clothsim/dynamics/bdf2.h"

#include "clothsim/dynamics/drag.h"

namespace clothsim {
namespace {

/// Does `change` differ from `last` as a hit does, not as a force that acts on?
bool is_hit(const Eigen::RowVector3d& change, const Eigen::RowVector3d& last) {
  return (change - last).norm() > 0.5 * (change.norm() + last.norm());
}

}  // namespace

void Bdf2::drop_history_of_hit_points(const State& state) {
  const Changes now{state.positions - returned_.positions, state.velocities - returned_.velocities};
  for (Eigen::Index i = 0; i < state.positions.rows(); ++i) {
    if (is_hit(now.positions.row(i), changes_.positions.row(i)) ||
        is_hit(now.velocities.row(i), changes_.velocities.row(i))) {
      has_history_[static_cast<std::size_t>(i)] = false;
    }
  }
  changes_ = now;
}

void Bdf2::step(const Cloth& cloth, const Loads& loads, double h, State& state) {
  const int n = cloth.num_points();
  if (watch_.changed(cloth, h)) {
    has_history_.assign(static_cast<std::size_t>(n), false);
    changes_ = {Points::Zero(n, 3), Points::Zero(n, 3)};
    last_ = state;
  } else {
    drop_history_of_hit_points(state);
  }

  // Where points go without springs, and what holds them there.
  const Drag drag(cloth.damping, h);
  const double e = drag.decay;
  const double time = (3 - e) / 3 * drag.distance;  // of the force
  weights_.setZero(n);
  Scalars gain = Scalars::Constant(n, 2 * h / 3);  // displacement per change of velocity [s]
  const State start = state;
  for (int i = 0; i < n; ++i) {
    auto x = state.positions.row(i);
    auto v = state.velocities.row(i);
    if (cloth.inv_mass[i] == 0) {
      x += h * v;
    } else if (has_history_[static_cast<std::size_t>(i)]) {
      v = e / 3 * (4 * v - e * last_.velocities.row(i)) + time * loads.gravity.transpose();
      x += (x - last_.positions.row(i)) / 3 + gain[i] * v;
      weights_[i] = cloth.mass[i] / (gain[i] * time);
    } else {
      gain[i] = h;
      v = e * v + drag.distance * loads.gravity.transpose();
      x += h * v;
      weights_[i] = cloth.mass[i] / (h * drag.distance);
    }
  }
  last_ = start;

  solver_.solve(cloth, weights_, state.positions, displacement_);
  state.positions += displacement_;
  state.velocities.array() += displacement_.array().colwise() / gain.array();

  returned_ = state;
  has_history_.assign(static_cast<std::size_t>(n), true);
}

}  // namespace clothsim
