// Chains, strings and membranes against statics and their exact modes.

#include <cmath>

#include "verification/testing.h"

namespace clothsim::chain_test {
namespace {

using namespace test;

constexpr double g = 9.8;
const Loads no_gravity{Vector3::Zero()};

/// Runs until every motion of rate `min_rate` [1/s] or faster has died to rounding.
template <typename Method>
void settle(Method& method, const Cloth& cloth, double min_rate, double h, State& state) {
  run(method, cloth, Loads{}, h, static_cast<int>(35 / (min_rate * h)), state);
}

template <typename Method>
class Statics : public ::testing::Test {};
TYPED_TEST_SUITE(Statics, EachMethod);

TYPED_TEST(Statics, HangingChainLinkByLink) {
  // The link with j masses below it carries their weight: k (l_j - L0) = j m g. At rest the forces
  // vanish in every method, so only rounding is left: 1e-9 of the largest stretch.
  const int links = 10;
  const double spacing = 1;
  const double k = 2000;
  ClothSpec spec = chain_spec(links + 1, spacing, k, Orientation::vertical);
  spec.pinned = {{0, links, ""}};
  // The slowest mode, 2 sqrt(k / m) sin(pi / 2 (2 n + 1)) = 6.7 rad/s, damped by less than its
  // critical rate dies at c / 2.
  spec.material.damping = 10;
  const Cloth cloth = make_grid(spec);
  State state{cloth.rest_positions, Points::Zero(links + 1, 3), 0};
  auto method = converged<TypeParam>();
  settle(method, cloth, spec.material.damping / 2, 5e-3, state);

  const double m = 1;
  const double total = m * g * links * (links + 1) / (2 * k);
  for (int below = 1; below <= links; ++below) {
    const double length = state.positions(below, 2) - state.positions(below - 1, 2);
    EXPECT_NEAR(length - spacing, below * m * g / k, 1e-9 * total) << below << " masses below";
  }
  EXPECT_NEAR(spacing * links - (state.positions(links, 2) - state.positions(0, 2)), -total,
              1e-9 * total);
}

TEST(StrainLimitStatics, HangingChainStretchesToItsLimitAndNoFurther) {
  // Hooke's law below the limit, the limit above: l_j / L0 - 1 = min(j m g / (k L0), limit), where
  // a spring at its limit is within the solver's tolerance of it.
  const int links = 10;
  Scene scene;
  scene.cloth = chain_spec(links + 1, 0.1, 1000, Orientation::vertical);
  scene.cloth.pinned = {{0, links, ""}};
  scene.cloth.material.damping = 10;
  scene.cloth.material.strain_limit = 0.5;
  Simulator simulator(scene);
  run(simulator, 12);

  const double tolerance = scene.simulation.strain_tolerance;
  const Points& x = simulator.state().positions;
  int at_limit = 0;
  for (int below = 1; below <= links; ++below) {
    const double stretch = (x.row(below) - x.row(below - 1)).norm() / 0.1 - 1;
    const double hooke = below * g / (1000 * 0.1);
    if (hooke < 0.5) {
      EXPECT_NEAR(stretch, hooke, 1e-3) << below << " masses below";
    } else {
      EXPECT_NEAR(stretch, 0.5, tolerance) << below << " masses below";
      ++at_limit;
    }
  }
  EXPECT_EQ(at_limit, 5);
}

/// A chain of equal elastic links and masses between two points at one height `span` apart: the
/// exact equilibrium. Horizontal tension H is the same in all links; the link j from the middle has
/// vertical tension V_j, so it is T = sqrt(H^2 + V^2), its length L0 (1 + T / (k L0)).
Points hanging_chain(int links, double rest, double k, double m, double span) {
  const auto shape = [&](double h) {
    Points x = Points::Zero(links + 1, 3);
    for (int i = 0; i < links; ++i) {
      const double v = m * g * (i - (links - 1) / 2.0);
      const double t = std::hypot(h, v);
      const double length = rest + t / k;
      x.row(i + 1) = x.row(i) + Eigen::RowVector3d(0, length * h / t, length * v / t);
    }
    return x;
  };
  // The span grows with H.
  double low = 1e-9 * m * g;
  double high = 1e6 * m * g * links;
  for (int i = 0; i < 200; ++i) {
    const double middle = std::sqrt(low * high);
    (shape(middle)(links, 1) < span ? low : high) = middle;
  }
  return shape(low);
}

TEST(VerletStatics, StiffChainHangsAsACatenary) {
  // y = a cosh(x / a), with a from the span: 2 a sinh(span / 2 a) = L. A chain of n links differs
  // by chords, O(1 / n^2), and by its stretch, T / (k L0) < 1e-4.
  const double length = 1;
  const double span = 0.8;
  double low = 0.01;
  double high = 10;
  for (int i = 0; i < 100; ++i) {
    const double a = (low + high) / 2;
    (2 * a * std::sinh(span / (2 * a)) > length ? low : high) = a;
  }
  const double a = low;

  std::vector<double> errors;
  for (const int links : {10, 20}) {
    // 1 kg in all, so that T < 10 N; masses at the points, half a link's weight at each end.
    const double rest = length / links;
    ClothSpec spec = chain_spec(links + 1, rest, 1e5 * links);
    spec.material.density = (links + 1.0) / links / length;
    spec.material.damping = 8;
    spec.pinned = {{0, 0, ""}, {0, links, ""}};
    const Cloth cloth = make_grid(spec);
    ASSERT_NEAR(cloth.mass[0], 1.0 / links, 1e-12);

    // From a V of the right length, damped to rest: the slowest mode is near sqrt(g / L).
    State state{cloth.rest_positions, Points::Zero(links + 1, 3), 0};
    for (int i = 0; i <= links; ++i) {
      const double s = std::abs(2.0 * i / links - 1);
      state.positions.row(i) << 0, span * i / links, (s - 1) * 0.3;
    }
    VelocityVerlet method;
    const double h = 0.5 / std::sqrt(4 * 1e5 * links * links);
    settle(method, cloth, 3, h, state);

    const Points exact = hanging_chain(links, rest, 1e5 * links, 1.0 / links, span);
    EXPECT_LT(farthest(state.positions, exact), 1e-7) << links << " links";

    double error = 0;
    for (int i = 0; i <= links; ++i) {
      const double x = state.positions(i, 1) - span / 2;
      const double y = a * (std::cosh(x / a) - std::cosh(span / (2 * a)));
      error = std::max(error, std::abs(state.positions(i, 2) - y));
    }
    errors.push_back(error);
  }
  EXPECT_LT(errors[1], 1e-3);
  EXPECT_NEAR(errors[0] / errors[1], 4, 0.5) << errors[0] << " " << errors[1];
}

/// Amplitude of `mode` (N x 1, orthogonal to the others) in the z of a state.
double project(const Scalars& mode, const State& state) {
  return mode.dot(state.positions.col(2)) / mode.squaredNorm();
}

TYPED_TEST(Statics, TautStringSwingsAtItsExactFrequencies) {
  // N inner points of mass m, spacing a, tension T: omega_p = 2 sqrt(T / (m a))
  // sin(p pi / 2(N + 1)). Over a period, a method of order p turns the phase by at most
  // 2 pi (omega h)^p; the amplitude A changes T by less than (p pi A / L)^2 k a / T of itself.
  const int inner = 9;
  const double rest = 0.1;
  const double stretch = 1.5;
  const double k = 100;
  ClothSpec spec = chain_spec(inner + 2, rest, k);
  spec.pinned = {{0, 0, ""}, {0, inner + 1, ""}};
  const Cloth cloth = make_grid(spec);
  const double a = rest * stretch;
  const double tension = k * (a - rest);
  const double amplitude = 1e-5;

  for (const int p : {1, 2, 5, 9}) {
    Scalars mode(inner + 2);
    for (int i = 0; i < inner + 2; ++i) mode[i] = std::sin(p * M_PI * i / (inner + 1));
    State state{stretch * cloth.rest_positions, Points::Zero(inner + 2, 3), 0};
    state.positions.col(2) = amplitude * mode;

    const double omega = 2 * std::sqrt(tension / a) * std::sin(p * M_PI / (2 * (inner + 1)));
    const int steps = 2000;  // a quarter period, where the phase shows
    const double h = 2 * M_PI / omega / steps;
    TypeParam method;
    run(method, cloth, no_gravity, h, steps / 4, state);
    const double share = 2 * M_PI * std::pow(omega * h, TypeParam::order) + 1e-7;
    EXPECT_NEAR(project(mode, state), 0, share * amplitude) << "mode " << p;
    run(method, cloth, no_gravity, h, steps / 4, state);
    EXPECT_NEAR(project(mode, state), -amplitude, share * amplitude) << "mode " << p;
  }
}

TYPED_TEST(Statics, TautMembraneSwingsAtItsExactFrequencies) {
  // omega^2 = (4 T / (m a)) (sin^2(p pi / 2(N + 1)) + sin^2(q pi / 2(N + 1))), structural springs.
  const int inner = 7;
  const int side = inner + 2;
  const double stretch = 1.4;
  ClothSpec spec = square_spec(side, 100);
  spec.origin = Vector3::Zero();
  spec.material.springs = {true, false, false};
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      if (i == 0 || j == 0 || i == side - 1 || j == side - 1) spec.pinned.push_back({i, j, ""});
    }
  }
  const Cloth cloth = make_grid(spec);
  const double a = stretch / (side - 1);
  const double tension = spec.material.ks * (stretch - 1) / (side - 1);
  const double amplitude = 1e-5;

  for (const auto& [p, q] : {std::pair(1, 1), std::pair(2, 1), std::pair(3, 4), std::pair(7, 7)}) {
    Scalars mode(side * side);
    for (int i = 0; i < side * side; ++i) {
      mode[i] = std::sin(p * M_PI * (i % side) / (inner + 1)) *
                std::sin(q * M_PI * (i / side) / (inner + 1));
    }
    State state{stretch * cloth.rest_positions, Points::Zero(side * side, 3), 0};
    state.positions.col(2) = amplitude * mode;

    const double sp = std::sin(p * M_PI / (2 * (inner + 1)));
    const double sq = std::sin(q * M_PI / (2 * (inner + 1)));
    const double omega = std::sqrt(4 * tension / (cloth.mass[0] * a) * (sp * sp + sq * sq));
    const int steps = 2000;
    const double h = 2 * M_PI / omega / steps;
    TypeParam method;
    run(method, cloth, no_gravity, h, steps / 4, state);
    const double share = 2 * M_PI * std::pow(omega * h, TypeParam::order) + 1e-7;
    EXPECT_NEAR(project(mode, state), 0, share * amplitude) << "mode " << p << ", " << q;
    run(method, cloth, no_gravity, h, steps / 4, state);
    EXPECT_NEAR(project(mode, state), -amplitude, share * amplitude) << "mode " << p << ", " << q;
  }
}

}  // namespace
}  // namespace clothsim::chain_test
