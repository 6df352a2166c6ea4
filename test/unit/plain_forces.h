#pragma once

#include <algorithm>
#include <cmath>
#include <random>

#include "algebra.h"
#include "clothsim/dynamics/forces.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/workers.h"

// Forces of a cloth anywhere near its rest shape, and plain twins of gradients and frequencies.

namespace clothsim::test {

/// The cloth's points moved at random by up to `most` [m].
inline Points moved(const Cloth& cloth, double most, unsigned seed = 3) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<> random(-most, most);
  Points x = cloth.rest_positions;
  for (Eigen::Index i = 0; i < x.size(); ++i) x.data()[i] += random(engine);
  return x;
}

inline const Loads none{Vector3::Zero()};

inline Points forces_at(const Cloth& cloth, const Points& x, const Points* velocities = nullptr,
                        const Workers& workers = {}) {
  Points forces;
  compute_forces(cloth, none, x, forces, workers, velocities);
  return forces;
}

/// The largest difference of a gradient and central differences of a function.
template <typename Function>
double gradient_error(const Function& function, Points x, const Points& gradient) {
  constexpr double step = 1e-6;
  double error = 0;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double at = x.data()[i];
    x.data()[i] = at + step;
    const double above = function(x);
    x.data()[i] = at - step;
    const double below = function(x);
    x.data()[i] = at;
    error = std::max(error, std::abs((above - below) / (2 * step) - gradient.data()[i]));
  }
  return error;
}

/// Exact highest frequency of the elastic forces [rad/s], by differences.
inline double exact_omega(const Cloth& cloth, const Points& at) {
  const Eigen::Index size = 3 * cloth.num_points();
  Eigen::MatrixXd matrix(size, size);
  Points x = at;
  for (Eigen::Index c = 0; c < size; ++c) {
    constexpr double step = 1e-6;
    x.data()[c] += step;
    const Points above = forces_at(cloth, x);
    x.data()[c] -= 2 * step;
    const Points change = (above - forces_at(cloth, x)) / (2 * step);
    x.data()[c] += step;
    matrix.col(c) = -change.reshaped();
  }
  const Eigen::VectorXd root = cloth.inv_mass.cwiseSqrt().replicate(3, 1);
  const Eigen::MatrixXd scaled =
      root.asDiagonal() * (matrix + matrix.transpose()) / 2 * root.asDiagonal();
  return std::sqrt(eigenvalues(scaled).maxCoeff());
}

}  // namespace clothsim::test
