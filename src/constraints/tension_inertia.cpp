#include "clothsim/constraints/tension_inertia.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace clothsim {
namespace {

/// Inertia added, of h^2 sum(T / l). More keeps longer steps stable than the weight asks for, but
/// passes have a harder time with masses that differ: at 0.5 a cloth of 50 x 50 points may shake
/// for want of them.
constexpr double added = 0.4;

/// What inertia keeps of itself from step to step where tension falls. Passes that end early leave
/// noise in tension, and inertia that followed that would make the next step's: at 0.9 the same
/// cloth may shake for ever.
constexpr double kept = 0.97;

}  // namespace

TensionInertia::TensionInertia(const Cloth& cloth)
    : stiffness_(Scalars::Zero(cloth.num_points())) {}

void TensionInertia::weigh(const Cloth& cloth, double h, const State& state, Scalars& inv_mass) {
  inv_mass = cloth.inv_mass;
  const double time2 = added * h * h;
  const auto is_slack = [&](int i) {
    const double mass = cloth.mass[i] + time2 * stiffness_[i];
    const bool slack = mass == cloth.mass[i] || cloth.inv_mass[i] == 0;  // held since, perhaps
    if (slack) {
      stiffness_[i] = 0;
    } else {
      inv_mass[i] = 1 / mass;
    }
    return slack;
  };
  tense_.erase(std::remove_if(tense_.begin(), tense_.end(), is_slack), tense_.end());
  carried_.clear();
  const bool is_held = cloth.inv_mass.minCoeff() == 0;
  if (is_held) return;
  for (const int i : tense_)
    carried_.push_back({i, time2 * stiffness_[i], row(state.velocities, i)});
}

void TensionInertia::give_back(const Cloth& cloth, double h, double reach, State& state) {
  if (carried_.empty()) return;  // the cloth is held, or slack

  // About the centre of mass where the step's impulses act.
  const Points middle = state.positions - reach * h * state.velocities;
  const double mass = cloth.mass.sum();
  const Vector3 centre = (cloth.mass.transpose() * middle).transpose() / mass;
  const double decay = std::exp(-cloth.damping * h);
  Vector3 momentum(0, 0, 0), angular_momentum(0, 0, 0);
  for (const Carried& c : carried_) {
    const Vector3 taken = c.mass * (row(state.velocities, c.point) - decay * c.velocity);
    momentum += taken;
    angular_momentum += (row(middle, c.point) - centre).cross(taken);
  }
  carried_.clear();

  // As a rigid motion of the whole.
  const Points arms = middle.rowwise() - centre.transpose();
  const Eigen::Matrix3d spread = arms.transpose() * cloth.mass.asDiagonal() * arms;
  const Eigen::Matrix3d inertia = spread.trace() * Eigen::Matrix3d::Identity() - spread;
  const Vector3 turn = inertia.completeOrthogonalDecomposition().solve(angular_momentum);
  const Vector3 shift = momentum / mass;
  Eigen::Matrix3d cross;  // a row times it: turn x row
  cross << 0, turn.z(), -turn.y(), -turn.z(), 0, turn.x(), turn.y(), -turn.x(), 0;
  const Points given = (arms * cross).rowwise() + shift.transpose();
  state.velocities += given;
  state.positions += reach * h * given;
}

double TensionInertia::share(const Cloth& cloth, double h) const {
  double sum = 0;
  for (const int i : tense_) sum += stiffness_[i];
  return added * h * h * sum / cloth.mass.sum();
}

void TensionInertia::fade() {
  for (const int i : tense_) stiffness_[i] *= kept;
}

void TensionInertia::add(int point, double stiffness) {
  if (stiffness == 0) return;
  if (stiffness_[point] == 0) tense_.push_back(point);
  stiffness_[point] = std::max(stiffness_[point], stiffness);
}

void TensionInertia::reset() {
  for (const int i : tense_) stiffness_[i] = 0;
  tense_.clear();
  carried_.clear();
}

void TensionInertia::write(MemoryWriter& memory) const {
  memory.add(static_cast<double>(tense_.size()));
  for (const int i : tense_) {
    memory.add(i);
    memory.add(stiffness_[i]);
  }
}

void TensionInertia::read(MemoryReader& memory) {
  reset();
  for (std::size_t left = memory.count(); left > 0; --left) {
    const int point = memory.index(static_cast<std::size_t>(stiffness_.size()));
    const double stiffness = std::max(0.0, memory.number());
    if (stiffness_[point] == 0 && stiffness > 0) tense_.push_back(point);
    stiffness_[point] = stiffness;
  }
}

}  // namespace clothsim
