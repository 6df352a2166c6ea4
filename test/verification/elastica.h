#pragma once

#include <cmath>
#include <utility>

#include "clothsim/dynamics/implicit_euler.h"
#include "verification/testing.h"

namespace clothsim::test {

struct EndOfStrip {
  double drop;
  double reach;
};

/// Curvature k of a moment k + stiffening k^3.
inline double curvature_at(double moment, double stiffening) {
  if (stiffening == 0) return moment;
  const double root = std::sqrt(3 * stiffening);
  return 2 / root * std::sinh(std::asinh(1.5 * root * moment) / 3);
}

/// Free end of the elastica of length 1 under its own weight, m' = -gamma t cos(theta) with t from
/// the free end, theta the angle below the horizontal, m(0) = 0, theta(1) = 0. Its moment m is that
/// of curvature theta' = k: k + stiffening k^3.
inline EndOfStrip elastica(double gamma, double stiffening = 0) {
  constexpr int steps = 20000;
  constexpr double h = 1.0 / steps;
  const auto integrate = [&](double end_angle) {
    double angle = end_angle, moment = 0;
    EndOfStrip end{0, 0};
    for (int i = 0; i < steps; ++i) {  // the midpoint rule
      const double t = i * h;
      const double middle = angle + h / 2 * curvature_at(moment, stiffening);
      const double middle_moment = moment - h / 2 * gamma * t * std::cos(angle);
      end.drop += h * std::sin(middle);
      end.reach += h * std::cos(middle);
      moment -= h * gamma * (t + h / 2) * std::cos(middle);
      angle += h * curvature_at(middle_moment, stiffening);
      if (angle < 0) break;  // it swings back from there
    }
    return std::pair(angle, end);
  };
  double low = 0, high = M_PI / 2;
  for (int i = 0; i < 50; ++i) {
    const double middle = (low + high) / 2;
    (integrate(middle).first < 0 ? low : high) = middle;
  }
  return integrate((low + high) / 2).second;
}

/// Rest places of the points, by steps of implicit Euler that are long compared with all swings and
/// that all converge.
inline Points at_rest(const Cloth& cloth) {
  State state{cloth.rest_positions, Points::Zero(cloth.num_points(), 3), 0};
  ImplicitEuler::Parameters parameters;
  parameters.tolerance = 1e-6;
  parameters.max_iterations = 100;
  ImplicitEuler method(parameters);
  for (int i = 0; i < 400; ++i) {
    method.step(cloth, Loads{}, 0.1, state);
    if (rms_velocity(state) < 1e-6) break;
  }
  EXPECT_LT(rms_velocity(state), 1e-5);
  return state.positions;
}

}  // namespace clothsim::test
