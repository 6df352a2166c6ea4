#include "clothsim/dynamics/internal_damping.h"

#include "clothsim/dynamics/bends.h"
#include "clothsim/dynamics/springs.h"

namespace clothsim {
namespace {

double length_of(const Points& positions, int a, int b) {
  return (positions.row(b) - positions.row(a)).norm();
}

}  // namespace

Past past_of(const Cloth& cloth, const Points& positions, double h) {
  if (!is_damped(cloth)) return {};
  Past past{h, {}, positions};
  for_each_spring(cloth, [&](const SpringRun&, int a, int b) {
    past.lengths.push_back(length_of(positions, a, b));
  });
  return past;
}

Past past_of(const Cloth& cloth, const Points& positions, const Points& last, double h) {
  if (!is_damped(cloth)) return {};
  Past past{2 * h / 3, {}, (4 * positions - last) / 3};
  for_each_spring(cloth, [&](const SpringRun&, int a, int b) {
    past.lengths.push_back((4 * length_of(positions, a, b) - length_of(last, a, b)) / 3);
  });
  return past;
}

double damping_potential(const Cloth& cloth, const Past& past, const Points& positions) {
  if (past.empty()) return 0;
  double of_springs = 0;
  std::size_t id = 0;
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const double change = length_of(positions, a, b) - past.lengths[id++];
    of_springs += run.stiffness * change * change / 2;
  });
  double of_bends = 0;
  for_each_bend(cloth, [&](const Bend& bend) {
    of_bends += bend.stiffness * (bend.of(positions) - bend.of(past.points)).squaredNorm() / 2;
  });
  const auto& [springs, bends] = cloth.internal_damping;
  return (springs * of_springs + bends * of_bends) / past.time;
}

void add_damping_gradient(const Cloth& cloth, const Past& past, const Points& positions,
                          Points& gradient) {
  if (past.empty()) return;
  const auto add = [&](int a, int b, const Eigen::RowVector3d& pull) {
    gradient.row(a) -= pull;
    gradient.row(b) += pull;
  };
  const auto& [springs, bends] = cloth.internal_damping;
  std::size_t id = 0;
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const Eigen::RowVector3d d = positions.row(b) - positions.row(a);
    const double length = d.norm();
    const double change = length - past.lengths[id++];
    if (length > 0) add(a, b, springs / past.time * run.stiffness * change / length * d);
  });
  for_each_bent_pair(cloth, [&](double w, int a, int b) {
    const Eigen::RowVector3d change =
        (positions.row(b) - positions.row(a)) - (past.points.row(b) - past.points.row(a));
    add(a, b, bends / past.time * w * change);
  });
}

}  // namespace clothsim
