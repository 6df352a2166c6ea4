#include "clothsim/dynamics/xpbd.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "clothsim/dynamics/drag.h"
#include "clothsim/dynamics/springs.h"

namespace clothsim {

/// Colours springs in their order, each with the first colour that neither of its points has yet:
/// at most twice the springs of a point, less one.
void Xpbd::build(const Cloth& cloth, double h) {
  const double time2 = h * Drag(cloth.damping, h).distance;
  std::vector<std::vector<Constraint>> colours;
  std::vector<std::uint64_t> taken(static_cast<std::size_t>(cloth.num_points()), 0);
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const double inv_mass = cloth.inv_mass[a] + cloth.inv_mass[b];
    if (run.stiffness == 0 || inv_mass == 0) return;
    std::uint64_t& of_a = taken[static_cast<std::size_t>(a)];
    std::uint64_t& of_b = taken[static_cast<std::size_t>(b)];
    std::size_t colour = 0;
    while ((of_a | of_b) >> colour & 1) ++colour;
    of_a |= std::uint64_t{1} << colour;
    of_b |= std::uint64_t{1} << colour;
    if (colour == colours.size()) colours.emplace_back();
    const double compliance = 1 / (run.stiffness * time2);
    colours[colour].push_back({a, b, run.rest_length, compliance, 1 / (inv_mass + compliance)});
  });

  constraints_.clear();
  colour_ends_.clear();
  for (const std::vector<Constraint>& colour : colours) {
    constraints_.insert(constraints_.end(), colour.begin(), colour.end());
    colour_ends_.push_back(static_cast<int>(constraints_.size()));
  }
}

void Xpbd::sweep(const Cloth& cloth, Points& positions, const Workers& workers) {
  const auto sweep_one = [&](std::size_t c) {
    const Constraint& spring = constraints_[c];
    const Vector3 d = positions.row(spring.b) - positions.row(spring.a);
    const double length = d.norm();
    if (length == 0) return;  // has no direction
    const double change =
        (spring.rest_length - length - spring.compliance * lambda_[c]) * spring.share;
    lambda_[c] += change;
    const Eigen::RowVector3d push = (change / length) * d.transpose();
    positions.row(spring.a) -= cloth.inv_mass[spring.a] * push;
    positions.row(spring.b) += cloth.inv_mass[spring.b] * push;
  };
  int first = 0;
  for (const int end : colour_ends_) {
    workers.share(end - first, [&](int from, int to) {
      for (int c = first + from; c < first + to; ++c) sweep_one(static_cast<std::size_t>(c));
    });
    first = end;
  }
}

/// With r the way to start + w sum of lambda u: points go r / (1 + 2 w sum of |lambda| / l), since
/// a spring under tension lambda that is turned by a distance across it turns its push back by
/// lambda / l of that, and its other end may do the same. This converges however long the step.
void Xpbd::realign(const Cloth& cloth, Points& positions) {
  target_ = start_;
  turn_.setOnes(cloth.num_points());
  for (std::size_t c = 0; c < constraints_.size(); ++c) {
    const Constraint& spring = constraints_[c];
    const Vector3 d = positions.row(spring.b) - positions.row(spring.a);
    const double length = d.norm();
    if (length == 0) continue;
    const double push = lambda_[c] / length;
    const double w_a = cloth.inv_mass[spring.a];
    const double w_b = cloth.inv_mass[spring.b];
    target_.row(spring.a) -= w_a * push * d.transpose();
    target_.row(spring.b) += w_b * push * d.transpose();
    turn_[spring.a] += 2 * w_a * std::abs(push);
    turn_[spring.b] += 2 * w_b * std::abs(push);
  }
  positions.array() += (target_ - positions).array().colwise() / turn_.array();
}

void Xpbd::step(const Cloth& cloth, const Loads& loads, double h, State& state,
                const Workers& workers) {
  if (watch_.changed(cloth, h)) build(cloth, h);

  coast(cloth, loads, h, state);
  start_ = state.positions;
  lambda_.assign(constraints_.size(), 0);
  for (int i = 0; i < parameters_.iterations; ++i) {
    if (i > 0) realign(cloth, state.positions);
    sweep(cloth, state.positions, workers);
  }
  state.velocities += (state.positions - start_) / h;
}

}  // namespace clothsim
