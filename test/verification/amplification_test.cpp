// Each method on a linear oscillator is a linear map with an exact factor a step.
//
// y'' = -omega^2 (y - 1) in the variable z = omega (y - 1) - i v reads z' = i omega z.

#include <cmath>
#include <complex>

#include "verification/testing.h"

namespace clothsim::amplification_test {
namespace {

using namespace test;
using Complex = std::complex<double>;
using namespace std::complex_literals;

const Loads no_gravity{Vector3::Zero()};
constexpr double omega = 7;
constexpr double amplitude = 0.1;

/// A mass of 1 kg on a spring of 1 m along y, its other end pinned.
struct Oscillator {
  Oscillator() {
    ClothSpec spec = chain_spec(2, 1, omega * omega);
    spec.pinned = {{0, 0, ""}};
    cloth = make_grid(spec);
    state = {cloth.rest_positions, Points::Zero(2, 3), 0};
    state.positions(1, 1) += amplitude;
  }
  Complex z() const { return {omega * (state.positions(1, 1) - 1), -state.velocities(1, 1)}; }

  Cloth cloth;
  State state;
};

TEST(Amplification, ImplicitEulerLosesItsShareEachStep) {
  // z' = z / (1 - i omega h): amplitude (1 + h^2 omega^2)^(-n / 2). XPBD with a single spring is
  // the same method.
  const auto check = [](auto method, double omega_h) {
    const double h = omega_h / omega;
    Oscillator oscillator;
    const Complex start = oscillator.z();
    const Complex factor = 1.0 / (1.0 - 1i * omega_h);
    for (int n = 1; n <= 40; ++n) {
      method.step(oscillator.cloth, no_gravity, h, oscillator.state);
      const Complex expected = start * std::pow(factor, n);
      ASSERT_LT(std::abs(oscillator.z() - expected), 1e-12) << omega_h << ", step " << n;
      ASSERT_NEAR(std::abs(oscillator.z()),
                  omega * amplitude * std::pow(1 + omega_h * omega_h, -n / 2.0), 1e-12);
    }
  };
  for (const double omega_h : {0.05, 0.7, 3.0}) {
    check(ImplicitEuler(), omega_h);
    check(Xpbd(), omega_h);
  }
}

TEST(Amplification, Bdf2FollowsItsRecurrence) {
  // z'' (1 - 2 i omega h / 3) = (4 z' - z) / 3, after a first step of implicit Euler.
  for (const double omega_h : {0.05, 0.7, 3.0}) {
    Oscillator oscillator;
    Bdf2 method;
    Complex last = oscillator.z();
    Complex now = last / (1.0 - 1i * omega_h);
    for (int n = 1; n <= 40; ++n) {
      method.step(oscillator.cloth, no_gravity, omega_h / omega, oscillator.state);
      ASSERT_LT(std::abs(oscillator.z() - now), 1e-12) << omega_h << ", step " << n;
      const Complex next = (4.0 * now - last) / 3.0 / (1.0 - 2i * omega_h / 3.0);
      last = now;
      now = next;
    }
  }
}

TEST(Amplification, RungeKuttaIsTheSeriesOfTheExponential) {
  // R(q) = 1 + q + q^2 / 2 + q^3 / 6 + q^4 / 24 with q = i omega h.
  for (const double omega_h : {0.05, 0.7, 2.0, 2.8}) {
    const Complex q = 1i * omega_h;
    const Complex factor = 1.0 + q + q * q / 2.0 + q * q * q / 6.0 + q * q * q * q / 24.0;
    Oscillator oscillator;
    RungeKutta4 method;
    Complex expected = oscillator.z();
    for (int n = 1; n <= 40; ++n) {
      method.step(oscillator.cloth, no_gravity, omega_h / omega, oscillator.state);
      expected *= factor;
      ASSERT_LT(std::abs(oscillator.z() - expected), 1e-12) << omega_h << ", step " << n;
    }
  }
}

TEST(Amplification, SymplecticEulerStaysOnItsEllipse) {
  // It conserves omega^2 y^2 + v^2 - omega^2 h y v (Hairer, Lubich & Wanner, I.1.2) at any step.
  for (const double omega_h : {0.05, 0.7, 1.9}) {
    Oscillator oscillator;
    SymplecticEuler method;
    const auto invariant = [&] {
      const double y = oscillator.state.positions(1, 1) - 1;
      const double v = oscillator.state.velocities(1, 1);
      return omega * omega * y * y + v * v - omega * omega_h * y * v;
    };
    const double before = invariant();
    for (int n = 1; n <= 200; ++n) {
      method.step(oscillator.cloth, no_gravity, omega_h / omega, oscillator.state);
      ASSERT_NEAR(invariant(), before, 1e-11 * before) << omega_h << ", step " << n;
    }
  }
}

TEST(Amplification, Bdf2DoesNotGiveAHitAgain) {
  // A caller stops the mass once. It follows its new path at once: v = a h after the next step,
  // then a t, with a = -omega^2 y. With the old history a third of the lost speed would come back
  // as a bounce. The swing's curve is off by (omega t)^2 / 2 of that; the force, by h / 2.
  Oscillator oscillator;
  Bdf2 method;
  const double h = 1e-3;
  run(method, oscillator.cloth, no_gravity, h, 100, oscillator.state);
  const double y = oscillator.state.positions(1, 1) - 1;
  ASSERT_GT(std::abs(oscillator.state.velocities(1, 1)), 0.4);
  oscillator.state.velocities.row(1).setZero();
  for (int n = 1; n <= 20; ++n) {
    method.step(oscillator.cloth, no_gravity, h, oscillator.state);
    const double t = n * h;
    const double expected = -omega * omega * y * t;
    EXPECT_NEAR(oscillator.state.velocities(1, 1), expected, 0.02 * std::abs(expected) + 2e-3) << n;
    EXPECT_NEAR(oscillator.state.positions(1, 1) - 1 - y, expected * t / 2, 1e-5) << n;
  }
}

}  // namespace
}  // namespace clothsim::amplification_test
