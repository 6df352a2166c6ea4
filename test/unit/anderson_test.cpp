#include "clothsim/dynamics/anderson.h"

#include <Eigen/Cholesky>

#include "verification/testing.h"

namespace clothsim {
namespace {

using namespace testing;

/// x -> A x + b with the N x 3 numbers of x as one vector, a contraction with rate `rate`.
class Linear {
 public:
  Linear(int points, double rate) : offset_(random_points(points, 1, 1)) {
    const Eigen::Index n = offset_.size();
    Eigen::VectorXd rates(n);
    for (Eigen::Index i = 0; i < n; ++i) rates[i] = rate * double(i + 1) / double(n);
    rates_ = rates;
  }
  Points change(const Points& x) const {
    Points next = offset_;
    next.reshaped() += rates_.cwiseProduct(x.reshaped());
    return next - x;
  }

 private:
  Points offset_;
  Eigen::VectorXd rates_;
};

/// |change| after `iterations`.
double left_after(int iterations, int window) {
  const Linear linear(2, 0.99);
  Anderson anderson(window);
  Points x = Points::Zero(2, 3);
  for (int i = 0; i < iterations; ++i) anderson.next(linear.change(x), x);
  return linear.change(x).norm();
}

TEST(Anderson, SolvesALinearIterationInAsManyStepsAsUnknowns) {
  // Walker & Ni 2011, theorem 2.2: it is GMRES, done after 6 + 1 evaluations of 6 unknowns.
  EXPECT_GT(left_after(5, 6), 1e-6);
  EXPECT_LT(left_after(8, 6), 1e-9);
}

TEST(Anderson, WithoutAWindowIsThePlainIteration) {
  const Linear linear(2, 0.99);
  Points x = Points::Zero(2, 3);
  for (int i = 0; i < 10; ++i) x += linear.change(x);
  EXPECT_DOUBLE_EQ(left_after(10, 0), linear.change(x).norm());
  EXPECT_LT(left_after(10, 2), 0.5 * left_after(10, 0));
}

TEST(Anderson, StandsStillWhereNothingChanges) {
  Anderson anderson(3);
  Points x = random_points(4, 1, 1);
  const Points start = x;
  for (int i = 0; i < 5; ++i) anderson.next(Points::Zero(4, 3), x);
  EXPECT_EQ(x, start);
}

}  // namespace
}  // namespace clothsim
