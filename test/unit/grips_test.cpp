// Points attached to moving frames: their motion, the forces on the frames, tearing off.

#include "clothsim/simulation/grips.h"

#include <cmath>
#include <limits>

#include "clothsim/model/errors.h"
#include "says.h"
#include "verification/testing.h"

namespace clothsim::grips_test {
namespace {

using namespace test;

constexpr double g = 9.8;  // [m/s^2]

Scene free_cloth(const std::string& method = "auto") {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 10;
  scene.cloth.material.density = 5;  // 5 kg in all
  scene.simulation.method = method;
  return scene;
}

Pose at(double x, double y, double z, double angle = 0) {
  return {Vector3(x, y, z), Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vector3::UnitZ()))};
}

/// Two hands take the cloth by its corners.
void hold_corners(Simulator& simulator) {
  simulator.attach("left", at(0, 0, 1), {0});
  simulator.attach("right", at(1, 0, 1), {9});
}

TEST(Grips, FreePointsNearAPlaceAreThoseThatNothingHolds) {
  Simulator simulator(free_cloth());
  const auto near = [&](double radius, const Vector3& place = Vector3(0, 0, 1)) {
    return simulator.free_points_near(place, radius);
  };
  const double spacing = 1.0 / 9;
  EXPECT_EQ(near(1.01 * spacing), (std::vector<int>{0, 1, 10}));
  EXPECT_EQ(near(0), std::vector<int>{0});  // the bound is inclusive
  simulator.attach("hand", at(0, 0, 1), {1});
  EXPECT_EQ(near(1.01 * spacing), (std::vector<int>{0, 10}));
  EXPECT_THROW(near(0.5 * spacing, Vector3(spacing, 0, 1)), InvalidValue);  // held
  EXPECT_THROW(near(0.5, Vector3(0, 0, 2)), InvalidValue);                  // far away
  for (const double radius : {-0.1, 1e7, std::nan("")}) EXPECT_THROW(near(radius), InvalidValue);
}

TEST(Grips, PointsKeepTheirOffsetsInTheFrame) {
  Simulator simulator(free_cloth());
  simulator.attach("hand", at(0.1, 0, 1), {0, 1, 10}, {{}, strength_range.max});
  simulator.step();
  EXPECT_EQ(simulator.state().positions.row(0), simulator.cloth().rest_positions.row(0));

  // Moved by 0.2 m along y and turned by 90 degrees about its own z: (x, y) becomes (-y, x).
  const Pose target = at(0.1, 0.2, 1, M_PI / 2);
  simulator.move_grip("hand", target);
  simulator.step();
  const Points& x = simulator.state().positions;
  EXPECT_NEAR((x.row(0) - Eigen::RowVector3d(0.1, 0.1, 1)).norm(), 0, 1e-12);
  EXPECT_NEAR((x.row(1) - Eigen::RowVector3d(0.1, 0.2 + 1.0 / 9 - 0.1, 1)).norm(), 0, 1e-12);
  EXPECT_NEAR((x.row(10) - Eigen::RowVector3d(0.1 - 1.0 / 9, 0.1, 1)).norm(), 0, 1e-12);
  simulator.step();
  EXPECT_NEAR((x.row(0) - Eigen::RowVector3d(0.1, 0.1, 1)).norm(), 0, 1e-12) << "stays";
}

TEST(Grips, PointsMoveAtTheSpeedOfTheirFrame) {
  // Not all at once at the end of the frame.
  Simulator simulator(free_cloth());
  simulator.attach("hand", at(0, 0, 1), {0});
  simulator.move_grip("hand", at(0, 0, 1.009));
  simulator.step();
  EXPECT_NEAR(simulator.state().velocities(0, 2), 0.009 * 90, 1e-9);
}

class Carried : public ::testing::TestWithParam<std::string> {};

/// At rest the frames carry all: the sum of their forces is the weight of the whole cloth, and
/// each torque is that of its points about the frame's origin.
TEST_P(Carried, WeightIsThatOfTheClothAtRest) {
  Simulator simulator(free_cloth(GetParam()));
  hold_corners(simulator);
  run(simulator, 6);
  const Wrench left = simulator.grips().at("left").wrench;
  const Wrench right = simulator.grips().at("right").wrench;
  const Vector3 weight(0, 0, -5 * g);
  EXPECT_NEAR((left.force + right.force - weight).norm(), 0, 0.001 * weight.norm());
  EXPECT_NEAR((left.force.z() - right.force.z()) / weight.z(), 0, 0.01) << "not shared evenly";
  EXPECT_GT(left.force.x(), 1) << "the left hand is pulled to the right";
  EXPECT_NEAR(left.torque.norm(), 0, 1e-9) << "its point is at its origin";
}

INSTANTIATE_TEST_SUITE_P(Methods, Carried,
                         ::testing::Values("auto", "verlet", "rk4", "implicit_euler", "bdf2",
                                           "xpbd"));

TEST(Grips, MomentumBalancesHoweverFewStepsXpbdTakes) {
  // The wrench on the hands that swing a cloth is its weight, less the rate of its momentum.
  for (const int substeps : {1, 10}) {
    for (const bool is_fabric : {false, true}) {
      Scene scene = free_cloth("xpbd");
      scene.cloth.material.damping = 0;
      if (is_fabric) scene.cloth.material.fabric = {{600, 450}, 25, {1e-3, 1e-3}, {1e-4, 1e-2}};
      scene.simulation.substeps = substeps;
      Simulator simulator(scene);
      const GripForces rigid{{}, strength_range.max};
      simulator.attach("hand", at(0, 0, 1), {0, 1}, rigid);
      simulator.attach("other", at(0, 0.1, 1), {10}, rigid);  // with springs between the hands
      const double mass = simulator.cloth().mass.sum();
      for (int i = 1; i <= 30; ++i) {
        simulator.move_grip("hand", at(0.2 * std::sin(0.1 * i), 0, 1));
        const Vector3 before = momentum(simulator.cloth(), simulator.state());
        simulator.step();
        const Vector3 gained = momentum(simulator.cloth(), simulator.state()) - before;
        const auto& grips = simulator.grips();
        const Vector3 force = grips.at("hand").wrench.force + grips.at("other").wrench.force;
        const Vector3 expected =
            mass * scene.simulation.gravity - gained / simulator.frame_duration();
        ASSERT_LT((force - expected).norm(), 1e-9 * (mass * g + expected.norm()))
            << substeps << " substeps, frame " << i;
      }
    }
  }
}

TEST(Grips, WeightBorneByTheStrainLimitCountsToo) {
  Scene scene = free_cloth();
  scene.cloth.material.density = 500;
  Simulator simulator(scene);
  hold_corners(simulator);
  EXPECT_GT(run(simulator, 6).worst_stretch, 0.0999) << "no spring at its limit";
  const Vector3 carried =
      simulator.grips().at("left").wrench.force + simulator.grips().at("right").wrench.force;
  EXPECT_NEAR((carried / (500 * g) - Vector3(0, 0, -1)).norm(), 0, 0.001);
}

TEST(Grips, TorqueIsThatOfAWeightOnAnArm) {
  // A hanging chain, 0.3 m from the frame's origin: m g on that arm, of 2 + 3 points of 1 kg.
  Scene scene;
  scene.cloth = chain_spec(5, 0.1, 1e5);
  scene.cloth.origin = Vector3(0, 0, 1);
  scene.cloth.material.damping = 20;
  Simulator simulator(scene);
  simulator.attach("hand", at(-0.3, 0, 1), {0});
  run(simulator, 8);
  const Wrench wrench = simulator.grips().at("hand").wrench;
  EXPECT_NEAR((wrench.force - Vector3(0, 0, -5 * g)).norm(), 0, 0.01 * 5 * g);
  EXPECT_NEAR((wrench.torque - Vector3(0, 0.3 * 5 * g, 0)).norm(), 0, 0.01 * 0.3 * 5 * g);
}

TEST(Grips, ForceOfAnAccelerationIsThatOfTheMassMoved) {
  // F = m (g - a): all points in one hand, which speeds up by 3 m/s^2, without drag.
  Scene scene = free_cloth();
  scene.cloth.material.damping = 0;
  Simulator simulator(scene);
  std::vector<int> all(100);
  for (int i = 0; i < 100; ++i) all[static_cast<std::size_t>(i)] = i;
  simulator.attach("hand", at(0, 0, 1), all);
  const double a = 3;
  const double dt = simulator.frame_duration();
  for (int i = 1; i <= 20; ++i) {
    simulator.move_grip("hand", at(a / 2 * i * i * dt * dt, 0, 1));
    simulator.step();
  }
  const Vector3 force = simulator.grips().at("hand").wrench.force;
  EXPECT_NEAR((force - 5 * Vector3(-a, 0, -g)).norm(), 0, 1e-6);
}

TEST(Grips, TearOffAboveTheForce) {
  Simulator simulator(free_cloth());
  simulator.attach("weak", at(0, 0, 1), {0, 1}, {10, {}});
  simulator.attach("strong", at(1, 0, 1), {9}, {1e4, {}});
  run(simulator, 2);
  EXPECT_EQ(simulator.grips().count("weak"), 0u);
  EXPECT_EQ(simulator.grips().count("strong"), 1u);
  EXPECT_GT(simulator.cloth().inv_mass[0], 0);
  EXPECT_GT(simulator.cloth().inv_mass[1], 0);
  EXPECT_LT(simulator.state().positions(0, 2), 0.8) << "hangs from the other hand";
}

TEST(Grips, DetachedPointsFlyOn) {
  Simulator simulator(free_cloth());
  simulator.attach("hand", at(0, 0, 1), {0, 9, 90, 99});
  const double v = 2;  // [m/s]
  for (int i = 1; i <= 10; ++i) {
    simulator.move_grip("hand", at(i * v / 90, 0, 1));
    simulator.step();
  }
  simulator.detach({9, 0});
  EXPECT_EQ(simulator.grips().at("hand").held.size(), 2u);
  EXPECT_NEAR(simulator.state().velocities(0, 0), v, 1e-9);
  simulator.detach({90, 99});
  EXPECT_TRUE(simulator.grips().empty());
  simulator.step();
  EXPECT_GT(simulator.state().positions(0, 0), 10 * v / 90 + 0.001);
  EXPECT_EQ(simulator.cloth().inv_mass.minCoeff(), simulator.cloth().inv_mass.maxCoeff());
}

TEST(Grips, LeaveNoTraceAfterAReset) {
  Scene scene = free_cloth();
  scene.cloth.pinned = {{5, 5, ""}};
  scene.cloth.self_collision = SelfCollision::automatic;
  Simulator simulator(scene);
  run(simulator, 0.5);
  const State expected = simulator.state();
  simulator.reset();
  simulator.attach("hand", at(0, 0, 2), {0, 17, 99});
  run(simulator, 0.5);
  simulator.reset();
  EXPECT_TRUE(simulator.grips().empty());
  run(simulator, 0.5);
  EXPECT_EQ(simulator.state().positions, expected.positions);
}

TEST(Grips, HoldThroughAChangeOfMaterial) {
  Simulator simulator(free_cloth());
  hold_corners(simulator);
  run(simulator, 0.3);
  Material material = simulator.scene().cloth.material;
  material.density = 20;
  material.springs = {true, true, false};
  simulator.set_material(material);
  run(simulator, 0.3);
  EXPECT_EQ(simulator.state().positions.row(0), simulator.cloth().rest_positions.row(0));
  EXPECT_EQ(simulator.grips().size(), 2u);
}

TEST(Grips, AreSavedAndRestored) {
  Simulator simulator(free_cloth());
  hold_corners(simulator);
  const auto carry = [&](int i) {
    simulator.move_grip("left", at(0, 0.003 * i, 1, 0.01 * i));
    simulator.step();
  };
  for (int i = 0; i < 30; ++i) carry(i);
  const auto saved = simulator.save();
  for (int i = 30; i < 60; ++i) carry(i);
  const State expected = simulator.state();
  const Wrench wrench = simulator.grips().at("left").wrench;
  simulator.detach({0, 9});
  run(simulator, 0.1);

  simulator.restore(*saved);
  for (int i = 30; i < 60; ++i) carry(i);
  EXPECT_EQ(simulator.state().positions, expected.positions);
  EXPECT_EQ(simulator.state().velocities, expected.velocities);
  EXPECT_EQ(simulator.grips().at("left").wrench.force, wrench.force);
}

TEST(Grips, TouchingLayersMayBeHeldTogether) {
  // Two points in self contact in one hand have no mass between them: no division by zero.
  Scene scene = free_cloth();
  scene.cloth.orientation = Orientation::vertical;
  scene.cloth.thickness = 0.03;
  scene.cloth.self_collision = SelfCollision::automatic;
  scene.cloth.origin = Vector3(0, 0, 0);
  ColliderSpec ground;
  ground.name = "ground";
  ground.shape = Plane{};
  scene.colliders = {ground};
  Simulator simulator(scene);
  ASSERT_GT(run(simulator, 2).contacts, 20);
  std::vector<int> half;
  for (int i = 0; i < 50; ++i) half.push_back(i);
  simulator.attach("hand", at(0, 0, 0), half);
  for (int i = 0; i < 45; ++i) {
    simulator.move_grip("hand", at(0, 0, 0.01 * i));
    simulator.step();
  }
  EXPECT_TRUE(simulator.state().positions.allFinite());
  EXPECT_TRUE(simulator.grips().at("hand").wrench.force.allFinite());
}

TEST(Grips, RefuseAndChangeNothing) {
  Scene scene = free_cloth();
  scene.cloth.pinned = {{5, 5, ""}};
  Simulator simulator(scene);
  simulator.attach("left", at(0, 0, 1), {0, 1});
  const auto refused = [&](const std::vector<int>& points, std::optional<double> tear_force,
                           const std::string& message) {
    try {
      simulator.attach("right", at(1, 0, 1), points, {tear_force, {}});
      ADD_FAILURE() << "accepted: " << message;
    } catch (const InvalidValue& error) {
      EXPECT_TRUE(says(error.what(), message));
    }
    EXPECT_EQ(simulator.grips().size(), 1u);
  };
  refused({}, {}, "points: got none ... one");
  refused({100}, {}, "points.0: got 100 ... 0 to 99");
  refused({3, -1}, {}, "points.1: got -1 ... 0 to 99");
  refused({3, 4, 3}, {}, "points.2: got 3 ... again");
  refused({9, 1}, {}, "points.1: got 1 ... held");
  refused({55}, {}, "points.0: got 55 ... held");
  refused({9}, -2, "tear_force: got -2");
  refused({9}, std::numeric_limits<double>::quiet_NaN(), "tear_force: got nan");
  refused({9}, -std::numeric_limits<double>::quiet_NaN(), "tear_force: got nan");  // of x86's 0/0
  EXPECT_THROW(simulator.detach({0, 2}), InvalidValue);
  EXPECT_EQ(simulator.grips().at("left").held.size(), 2u);
  EXPECT_THROW(simulator.move_grip("right", at(0, 0, 0)), std::out_of_range);
}

}  // namespace
}  // namespace clothsim::grips_test
