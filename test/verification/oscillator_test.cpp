// One spring and its mass: period, exact frequency, order, stability; the pendulum.

#include <cmath>

#include "verification/testing.h"

namespace clothsim::oscillator_test {
namespace {

using namespace test;

const Loads no_gravity{Vector3::Zero()};

/// A mass of 1 kg on a spring of 1 m along y, its other end pinned: y'' = -omega^2 (y - 1).
Cloth oscillator(double omega) {
  ClothSpec spec = chain_spec(2, 1, omega * omega);
  spec.pinned = {{0, 0, ""}};
  return make_grid(spec);
}

State stretched_by(const Cloth& cloth, double amplitude) {
  State state{cloth.rest_positions, Points::Zero(2, 3), 0};
  state.positions(1, 1) += amplitude;
  return state;
}

template <typename Method>
class EveryMethod : public ::testing::Test {};
TYPED_TEST_SUITE(EveryMethod, EachMethod);

TYPED_TEST(EveryMethod, OscillatorComesBackAfterItsPeriod) {
  // T = 2 pi sqrt(m / k). A method of order p turns its phase (or loses amplitude) by less than
  // (omega h)^p a radian.
  const double omega = 7;
  const double period = 2 * M_PI / omega;
  const int steps = 1000;
  const Cloth cloth = oscillator(omega);
  const double amplitude = 0.1;
  State state = stretched_by(cloth, amplitude);
  TypeParam method;
  run(method, cloth, no_gravity, period / steps, steps, state);

  const double share = 2 * M_PI * std::pow(2 * M_PI / steps, TypeParam::order) + 1e-12;
  EXPECT_NEAR(state.positions(1, 1) - 1, amplitude, share * amplitude);
  EXPECT_NEAR(state.velocities(1, 1), 0, share * amplitude * omega);
  EXPECT_EQ(state.positions.row(0).norm(), 0) << "the pin moved";
}

TEST(Verlet, OscillatesAtItsExactDiscreteFrequency) {
  // y_n = A cos(w h n) with sin(w h / 2) = omega h / 2, and v_n from the same recurrence.
  const double omega = 7;
  const double amplitude = 0.1;
  const Cloth cloth = oscillator(omega);
  for (const double omega_h : {0.05, 0.5, 1.0, 1.9}) {
    const double h = omega_h / omega;
    const double wh = 2 * std::asin(omega_h / 2);
    State state = stretched_by(cloth, amplitude);
    VelocityVerlet method;
    for (int n = 1; n <= 1000; ++n) {
      method.step(cloth, no_gravity, h, state);
      ASSERT_NEAR(state.positions(1, 1) - 1, amplitude * std::cos(n * wh), 1e-10)
          << "omega h " << omega_h << ", step " << n;
      ASSERT_NEAR(state.velocities(1, 1),
                  -amplitude * omega * omega_h * std::sin(n * wh) / std::sin(wh), 1e-9)
          << "omega h " << omega_h << ", step " << n;
    }
  }
}

TYPED_TEST(EveryMethod, StabilityLimitFromBothSides) {
  // Stable for h omega < stability_limit: at 0.98 of it the swing stays within a bound, at 1.02 it
  // grows without bound. A symplectic method moves on an ellipse. Verlet's has the start at its
  // end; symplectic Euler's leans, and is 1 / sqrt(1 - (h omega / 2)^2) longer.
  const double limit = TypeParam::stability_limit;
  if (!std::isfinite(limit)) GTEST_SKIP() << TypeParam::name << " has no limit";
  const double omega = 7;
  const double amplitude = 1e-6;
  const Cloth cloth = oscillator(omega);
  const auto largest = [&](double share) {
    State state = stretched_by(cloth, amplitude);
    TypeParam method;
    double most = 0;
    for (int n = 0; n < 2000 && most < 1; ++n) {
      method.step(cloth, no_gravity, share * limit / omega, state);
      most = std::max(most, std::abs(state.positions(1, 1) - 1));
    }
    return most / amplitude;
  };
  const double lean =
      std::is_same_v<TypeParam, SymplecticEuler> ? 1 / std::sqrt(1 - 0.98 * 0.98) : 1;
  EXPECT_LT(largest(0.98), lean * (1 + 1e-6));
  EXPECT_GT(largest(1.02), 1e6);
}

TYPED_TEST(EveryMethod, ConvergesAtItsOrder) {
  // x_h = x + C h^p + ...: log2(|x_h - x_{h/2}| / |x_{h/2} - x_{h/4}|) = p, from both sides. A
  // cloth hung by two corners, with gravity, drag and large motion. It starts with some speed: from
  // rest, symplectic Euler's velocities are of order 2.
  ClothSpec spec = square_spec(6, 200);
  spec.material.damping = 2;
  spec.pinned = {{0, 0, ""}, {5, 0, ""}};
  const Cloth cloth = make_grid(spec);
  const double seconds = 0.4;
  const auto end = [&](int steps) {
    State state = start_state(spec, cloth, 1);
    state.velocities = random_points(cloth.num_points(), 0.5, 2);
    for (const int pin : cloth.pinned) state.velocities.row(pin).setZero();
    auto method = converged<TypeParam>();
    run(method, cloth, Loads{}, seconds / steps, steps, state);
    return state;
  };
  // omega_max is about sqrt(8 k / m) = 20 rad/s: omega_max h = 0.08, 0.04, 0.02.
  const State coarse = end(100);
  const State middle = end(200);
  const State fine = end(400);
  const double order_x = std::log2((coarse.positions - middle.positions).norm() /
                                   (middle.positions - fine.positions).norm());
  const double order_v = std::log2((coarse.velocities - middle.velocities).norm() /
                                   (middle.velocities - fine.velocities).norm());
  this->RecordProperty("order_position", std::to_string(order_x));
  this->RecordProperty("order_velocity", std::to_string(order_v));
  EXPECT_NEAR(order_x, TypeParam::order, 0.1);
  EXPECT_NEAR(order_v, TypeParam::order, 0.1);
}

/// Period of a swing that starts at rest: its rate vanishes after a half and after a whole one.
template <typename Swing>
double period_of(Swing&& next_angle_rate, double h) {
  double last = next_angle_rate();
  int turns = 0;
  for (int n = 2;; ++n) {
    const double rate = next_angle_rate();
    if (last * rate < 0 && ++turns == 2) return h * (n - 1 + last / (last - rate));
    last = rate;
  }
}

TYPED_TEST(EveryMethod, PendulumKeepsItsPeriod) {
  // T = 4 sqrt(L / g) K(sin(theta0 / 2)). The spring's force is at most (1 + 2 (1 - cos theta0)) m
  // g and lengthens L by that over k; T follows L by half its share, and by less than as much again
  // from the mass that moves out and in.
  const double g = 9.8;
  const double k = 1e7;
  const double theta0 = 2;
  const double h = 5e-5;
  ClothSpec spec = chain_spec(2, 1, k);
  spec.pinned = {{0, 0, ""}};
  const Cloth cloth = make_grid(spec);
  State state{cloth.rest_positions, Points::Zero(2, 3), 0};
  state.positions.row(1) << 0, std::sin(theta0), -std::cos(theta0);

  TypeParam method;
  const double period = period_of(
      [&] {
        method.step(cloth, Loads{}, h, state);
        const Vector3 x = state.positions.row(1).transpose();
        const Vector3 v = state.velocities.row(1).transpose();
        return x.y() * v.z() - x.z() * v.y();
      },
      h);
  const double exact = 4 * std::sqrt(1 / g) * std::comp_ellint_1(std::sin(theta0 / 2));
  const double elastic = (1 + 2 * (1 - std::cos(theta0))) * g / k;
  // A method of order p is off by less than (omega h)^p a radian; omega is fastest at the bottom.
  const double scheme = 2 * M_PI * std::pow(std::sqrt(g) * h, TypeParam::order);
  this->RecordProperty("relative_error", std::to_string(period / exact - 1));
  EXPECT_NEAR(period / exact, 1, elastic + scheme);
}

}  // namespace
}  // namespace clothsim::oscillator_test
