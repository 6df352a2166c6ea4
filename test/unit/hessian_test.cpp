#include "clothsim/dynamics/hessian.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "algebra.h"

namespace clothsim::hessian_test {
namespace {

constexpr double k = 700;
constexpr double rest_length = 0.3;

/// Hooke's force on the far end of a spring.
Vector3 pull(const Vector3& d) { return -k * (d.norm() - rest_length) * d.normalized(); }

/// Vectors of 0.1 to 3 rest lengths in all directions.
std::vector<Vector3> samples() {
  std::mt19937_64 engine(1);
  std::normal_distribution<double> draw;
  std::vector<Vector3> vectors;
  for (int i = 0; i < 60; ++i) {
    const Vector3 direction(draw(engine), draw(engine), draw(engine));
    vectors.emplace_back((0.1 + 2.9 * i / 59) * rest_length * direction.normalized());
  }
  return vectors;
}

TEST(SpringHessian, IsTheDerivativeOfTheForce) {
  // Central differences: (f(d - e) - f(d + e)) / 2 |e| is off by |e|^2 f''' / 6, f''' of the size
  // of k L0 / l^3, and by rounding.
  const double e = 1e-5;
  for (const Vector3& d : samples()) {
    Eigen::Matrix3d expected;
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3 step = e * Vector3::Unit(axis);
      expected.col(axis) = (pull(d - step) - pull(d + step)) / (2 * e);
    }
    const double length = d.norm();
    const double tolerance = 10 * e * e * k * rest_length / std::pow(length, 3) + 1e-9 * k;
    EXPECT_LT((spring_hessian(k, rest_length, d) - expected).norm(), tolerance) << length;
  }
}

TEST(SpringHessian, ClampedIsPositiveSemidefiniteAndElseTheSame) {
  int indefinite = 0;
  for (const Vector3& d : samples()) {
    const Eigen::Matrix3d exact = spring_hessian(k, rest_length, d);
    const Eigen::Matrix3d clamped = spring_hessian(k, rest_length, d, 0);
    const auto least = [](const Eigen::Matrix3d& matrix) { return test::eigenvalues(matrix)[0]; };
    EXPECT_GE(least(clamped), -1e-12 * k);
    EXPECT_GE(least(clamped - exact), -1e-12 * k) << "it only adds";
    if (d.norm() > rest_length) {
      EXPECT_EQ(clamped, exact);
    }
    if (least(exact) < -1e-6 * k) ++indefinite;
    // Along the spring it is k at any length.
    EXPECT_NEAR(d.normalized().dot(clamped * d.normalized()), k, 1e-12 * k);
  }
  EXPECT_GT(indefinite, 10);
}

TEST(SpringHessian, IsZeroWhereTheSpringHasNoDirection) {
  EXPECT_EQ(spring_hessian(k, rest_length, Vector3::Zero()), Eigen::Matrix3d::Zero());
  EXPECT_EQ(spring_hessian(k, rest_length, Vector3::Zero(), 0), Eigen::Matrix3d::Zero());
  // Without a rest length it is k in all directions.
  const Eigen::Matrix3d soft = spring_hessian(k, 0, Vector3(0.1, 0.2, 0.3), 0);
  EXPECT_LT((soft - k * Eigen::Matrix3d::Identity()).norm(), 1e-12 * k);
}

}  // namespace
}  // namespace clothsim::hessian_test
