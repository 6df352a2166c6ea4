// Impulses of contact that act in the steps of implicit methods, too.

#include <cmath>

#include "algebra.h"
#include "verification/testing.h"

namespace clothsim::lagged_contact_test {
namespace {

using namespace test;

constexpr double g = 9.8;
constexpr double radius = 0.05;
constexpr double middle = 0.3;  // height of the rod's axis [m]

/// A strip of cotton, 0.6 m long, over a rod.
Scene over_rod(const std::string& method, int substeps, double damping) {
  Scene scene;
  ClothSpec& cloth = scene.cloth;
  cloth.columns = 41;
  cloth.rows = 3;
  cloth.width = 0.6;
  cloth.height = 0.03;
  cloth.thickness = 5e-4;
  cloth.origin = Vector3(-0.3, -0.015, middle + radius + 0.0017);
  cloth.material.fabric = Fabric{{1600, 1600}, 40, {1e-6, 1e-6}, {1e-5, 1e-3}};
  cloth.material.density = 0.12;
  cloth.material.damping = damping;
  cloth.material.strain_limit.reset();
  ColliderSpec rod;
  rod.name = "rod";
  rod.shape = Capsule{0.2, radius};
  rod.pose = {{0, 0, middle}, turn_between(Vector3::UnitZ(), Vector3::UnitY())};
  rod.friction = 0.4;
  scene.colliders = {rod};
  scene.simulation.method = method;
  scene.simulation.substeps = substeps;
  return scene;
}

/// Largest stretch of the springs along the strip.
double stretch_along(const Cloth& cloth, const Points& positions) {
  double worst = 0;
  for (int i = 0; i + 1 < cloth.num_points(); ++i) {
    if ((i + 1) % cloth.columns == 0) continue;
    const double length = (positions.row(i + 1) - positions.row(i)).norm();
    const double rest = (cloth.rest_positions.row(i + 1) - cloth.rest_positions.row(i)).norm();
    worst = std::max(worst, length / rest - 1);
  }
  return worst;
}

class HangingStrip : public ::testing::TestWithParam<const char*> {};

TEST_P(HangingStrip, AHangingStripStretchesByItsWeight) {
  // The strain at the rod's sides is that of the weight below, some 1.7e-4. By each substep's fall
  // it would be 20 to 100 times as large, see LaggedContact.
  Simulator simulator(over_rod(GetParam(), 10, 3));
  run(simulator, 4);
  const Points& x = simulator.state().positions;
  const double hanging = 0.6 * static_cast<double>((x.col(2).array() < middle).count()) /
                         static_cast<double>(2 * x.rows());
  const double strain = 0.12 * g * hanging / 1600;
  const double stretch = stretch_along(simulator.cloth(), x);
  EXPECT_GT(stretch, 0.7 * strain);
  EXPECT_LT(stretch, 3 * strain);
  EXPECT_LT(rms_velocity(simulator.state()), 5e-3);
}

TEST_P(HangingStrip, MomentumBalances) {
  // In each frame the change of momentum is the impulse of the weight and of the rod.
  Simulator simulator(over_rod(GetParam(), 10, 0));
  run(simulator, 0.3);
  simulator.measure_wrenches(true);
  const double dt = simulator.frame_duration(), mass = simulator.cloth().mass.sum();
  for (int frame = 0; frame < 30; ++frame) {
    const Vector3 before = momentum(simulator.cloth(), simulator.state());
    simulator.step();
    const Vector3 change = momentum(simulator.cloth(), simulator.state()) - before;
    const Vector3 impulse =
        dt * (mass * Vector3(0, 0, -g) - simulator.collider_wrenches()[0].force);
    EXPECT_LT((change - impulse).norm(), 1e-9 * mass * g * dt) << "frame " << frame;
  }
}

TEST_P(HangingStrip, MomentumBalancesWithDrag) {
  // A substep of h leaves e^(-c h) of the momentum p, and turns a force F into F (1 - e^(-c h)) /
  // c.
  const double c = 5.4;
  Simulator simulator(over_rod(GetParam(), 1, c));
  run(simulator, 0.3);
  simulator.measure_wrenches(true);
  const double mass = simulator.cloth().mass.sum(), h = simulator.frame_duration();
  const double kept = std::exp(-c * h);
  for (int frame = 0; frame < 30; ++frame) {
    const Vector3 before = momentum(simulator.cloth(), simulator.state());
    simulator.step();
    const Vector3 change = momentum(simulator.cloth(), simulator.state()) - kept * before;
    const Vector3 force = mass * Vector3(0, 0, -g) - simulator.collider_wrenches()[0].force;
    const Vector3 expected = (1 - kept) / c * force;
    EXPECT_LT((change - expected).norm(), 1e-9 * mass * g * h) << "frame " << frame;
  }
}

TEST_P(HangingStrip, AHeldPointStaysWhereItIs) {
  // A point in contact that is attached has no lagged impulse: it neither moves nor slips.
  Simulator simulator(over_rod(GetParam(), 10, 5.4));
  run(simulator, 1);
  const int top = simulator.cloth().columns + 20;
  const Vector3 place = row(simulator.state().positions, top);
  simulator.attach("hand", {place, Eigen::Quaterniond::Identity()}, {top});
  for (int frame = 0; frame < 30; ++frame) {
    EXPECT_EQ(simulator.step().lagging, 0) << "frame " << frame;
    EXPECT_LT((row(simulator.state().positions, top) - place).norm(), 1e-12) << "frame " << frame;
  }
}

TEST_P(HangingStrip, ARestoredCopyContinuesWithTheSameBits) {
  // Over a box, whose edges touch triangles.
  Scene scene = over_rod(GetParam(), 10, 3);
  scene.colliders[0].shape = Cuboid{{0.1, 0.1, 0.1}};
  scene.cloth.self_collision = SelfCollision::surface;
  Simulator simulator(scene);
  run(simulator, 0.5);
  Simulator other(scene);
  other.set_state(simulator.state(), simulator.memory());
  run(simulator, 0.2);
  run(other, 0.2);
  EXPECT_TRUE(other.state().positions == simulator.state().positions);
  EXPECT_TRUE(other.state().velocities == simulator.state().velocities);
}

INSTANTIATE_TEST_SUITE_P(Methods, HangingStrip, ::testing::Values("xpbd", "implicit_euler"),
                         [](const auto& method) { return std::string(method.param); });

}  // namespace
}  // namespace clothsim::lagged_contact_test
