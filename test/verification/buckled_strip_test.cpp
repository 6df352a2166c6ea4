// A strip of fabric whose clamped ends approach, without gravity: Euler's elastica.

#include <cmath>

#include "verification/fabric_testing.h"

namespace clothsim::buckled_strip_test {
namespace {

using namespace test;

struct Buckled {
  double height;  // by the length
  double force;   // by the bending stiffness over the length squared
};

/// The ends of a clamped strip have approached by `share` of its length, 1 - share = 2 E / K - 1
/// with the complete elliptic integrals K and E of the modulus k: its height is k / K, its force
/// (4 K)^2 (Love 1927, A Treatise on the Mathematical Theory of Elasticity, section 263).
Buckled elastica(double share) {
  double low = 0, high = 0.9;
  for (int i = 0; i < 60; ++i) {
    const double k = (low + high) / 2;
    const double shortened = 2 - 2 * std::comp_ellint_2(k) / std::comp_ellint_1(k);
    (shortened < share ? low : high) = k;
  }
  const double quarter = std::comp_ellint_1(low);
  return {low / quarter, 16 * quarter * quarter};
}

TEST(BuckledStrip, IsTheElasticaWithTheMethodThatAutoTakes) {
  constexpr int columns = 63, rows = 3;
  constexpr double length = 0.2, share = 0.05, bending = 1e-4;
  constexpr double spacing = length / (columns - 2);  // clamped halfway between two points
  Scene scene;
  scene.cloth = fabric_spec(columns, rows, spacing, spacing);
  scene.cloth.material.damping = 5;
  scene.cloth.material.fabric = Fabric{{3000, 3000}, 60, {bending, bending}, {1e-5, 0.01}};
  scene.simulation.gravity.setZero();
  Simulator simulator(scene);

  State bent = simulator.state();
  for (Eigen::Index i = 0; i < bent.positions.rows(); ++i) {
    const double along = bent.positions(i, 0) / scene.cloth.width;
    bent.positions(i, 2) += 1e-3 * std::pow(std::sin(M_PI * along), 2);
  }
  simulator.set_state(bent);
  std::vector<int> left, right;
  for (int row = 0; row < rows; ++row) {
    for (const int column : {0, 1}) {
      left.push_back(row * columns + column);
      right.push_back(row * columns + columns - 1 - column);
    }
  }
  simulator.attach("left", {}, left);
  simulator.attach("right", {}, right);
  constexpr int closing = 90;
  for (int frame = 1; frame <= closing + 450; ++frame) {
    const double closed = share * length * std::min(1.0, 1.0 * frame / closing);
    simulator.move_grip("right", {Vector3(-closed, 0, 0), Eigen::Quaterniond::Identity()});
    simulator.step();
  }
  EXPECT_EQ(simulator.step().method, "bdf2") << "xpbd would bend to half the height";
  const Buckled exact = elastica(share);
  const auto z = simulator.state().positions.col(2);
  EXPECT_NEAR((z.maxCoeff() - z.minCoeff()) / length, exact.height, 0.01 * exact.height);
  const double force = simulator.grips().at("right").wrench.force.x() / scene.cloth.height;
  EXPECT_NEAR(std::abs(force) * length * length / bending, exact.force, 0.02 * exact.force);
}

}  // namespace
}  // namespace clothsim::buckled_strip_test
