#pragma once

#include <cmath>

#include "algebra.h"
#include "clothsim/dynamics/bend_rotation.h"
#include "clothsim/dynamics/bends.h"

namespace clothsim::test {

/// The rotation [rad/s] of remove_rotation() for a cloth of one piece, by least squares over its
/// stencils.
inline Vector3 plain_rotation(const Cloth& cloth, const Points& x, const Points& v) {
  const Eigen::Index rows = 3 * cloth.num_bends();
  Eigen::MatrixXd turning(rows + 3, 3);
  Eigen::VectorXd rates(rows + 3);
  Eigen::Index first = 0;
  for_each_bend(cloth, [&](const auto& bend) {
    const double weight = std::sqrt(bend.stiffness);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      turning.block<3, 1>(first, axis) = weight * Vector3::Unit(axis).cross(bend.deviation(x));
    }
    rates.segment<3>(first) = weight * bend.rate(x, v);
    first += 3;
  });
  double weights = 0;
  for_each_bent_pair(cloth, [&](double weight, int, int) { weights += weight; });
  turning.bottomRows<3>() = std::sqrt(weights) * min_bend * Eigen::Matrix3d::Identity();
  rates.tail<3>().setZero();
  return solve(turning, rates);
}

}  // namespace clothsim::test
