// Cloths that are pulled beyond their strain limit: pins give way and lag, the cloth keeps its
// limit and is still, and it hangs as before once it is released.

#include "clothsim/dynamics/energy.h"
#include "clothsim/dynamics/stretch.h"
#include "clothsim/run/report.h"
#include "hanging.h"
#include "verification/testing.h"

namespace clothsim::overpulled_test {
namespace {

using namespace test;

bool yields(const StepReport& report) { return report.reasons.has(Reason::limit_yields); }

/// Runs for `duration` [s]; no frame is taken back.
StepReport run_on(Simulator& simulator, double duration) {
  StepReport last;
  for (int frame = 0; frame < duration / simulator.frame_duration(); ++frame) {
    last = simulator.step();
    EXPECT_EQ(last.recoveries, 0) << simulator.state().time;
    EXPECT_TRUE(simulator.state().positions.allFinite());
  }
  return last;
}

void expect_as_ever(Simulator& simulator) {
  const StepReport report = run_on(simulator, 6);
  EXPECT_FALSE(yields(report)) << report.reasons.text();
  EXPECT_LT(report.worst_stretch, 0.105);
  EXPECT_LT(rms_velocity(simulator.state()), 0.01);
}

/// Pins apart by a share of the cloth's width, at a strain tolerance.
class PinsApart : public ::testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(PinsApart, LagAndTheClothIsStill) {
  const auto& [share, tolerance] = GetParam();
  Scene scene = hanging();
  scene.simulation.strain_tolerance = tolerance;
  Simulator simulator(scene);
  const auto pull = [&](double from, double to) {  // within a second
    constexpr int frames = 90;
    for (int i = 1; i <= frames; ++i) {
      simulator.move_pin(1, {1 + from + (to - from) * i / frames, 0, 1});
      simulator.step();
    }
  };
  run_on(simulator, 1);
  pull(0, share);
  const StepReport report = run_on(simulator, 4);
  EXPECT_GT(report.lagging, 0);
  EXPECT_LT(report.worst_stretch, 0.105);
  EXPECT_LT(rms_velocity(simulator.state()), 2e-3);
  for (const HolderReport& pin : simulator.holders()) {
    EXPECT_LE(pin.force, pin.strength * (1 + 1e-9)) << pin.name;
  }

  pull(share, 0);
  expect_as_ever(simulator);
}

// With a tight tolerance passes run out, too.
INSTANTIATE_TEST_SUITE_P(Shares, PinsApart,
                         ::testing::Values(std::tuple{0.11, 4e-3}, std::tuple{0.2, 4e-3},
                                           std::tuple{0.5, 4e-3}, std::tuple{2.0, 4e-3},
                                           std::tuple{0.2, 1e-7}));

/// A ball at a speed [m/s] against a cloth held by its corners, or all along its border.
class BallAgainst : public ::testing::TestWithParam<std::tuple<double, bool>> {};

TEST_P(BallAgainst, AHeldClothStretchesItWhichIsStill) {
  const auto& [speed, border] = GetParam();
  constexpr int side = 20;
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = side;
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      const int on_edges = (row % (side - 1) == 0) + (column % (side - 1) == 0);
      if (on_edges >= (border ? 1 : 2)) scene.cloth.pinned.push_back({column, row, ""});
    }
  }
  ColliderSpec ball;
  ball.name = "ball";
  ball.pose.position = Vector3(0.5, 0.5, 0.7);
  ball.friction = 0.5;
  scene.colliders = {ball};
  Simulator simulator(scene);
  Pose pose = ball.pose;
  const auto lift_to = [&](double height, double at) {
    const double way = at * simulator.frame_duration();
    while (std::abs(height - pose.position.z()) > way / 2) {
      pose.position.z() += height > pose.position.z() ? way : -way;
      simulator.move_collider(0, pose);
      EXPECT_EQ(simulator.step().recoveries, 0) << pose.position.z();
    }
  };
  lift_to(1.25, speed);
  const StepReport report = run_on(simulator, 4);
  EXPECT_GT(report.lagging, 0);
  // The pins of a border carry more together than the bound of a step allows: the limit gives way,
  // and trembles.
  const double still = border ? 0.04 : 0.02;
  EXPECT_LT(rms_velocity(simulator.state()), still);
  EXPECT_LT(max_speed(simulator.state()), 5 * still);
  EXPECT_LT(deepest_penetration(simulator), 1e-3);

  lift_to(0.2, 0.5);
  expect_as_ever(simulator);
}

INSTANTIATE_TEST_SUITE_P(Speeds, BallAgainst,
                         ::testing::Values(std::tuple{0.1, false}, std::tuple{0.4, true},
                                           std::tuple{1.0, false}, std::tuple{1.0, true},
                                           std::tuple{10.0, false}, std::tuple{10.0, true}));

/// A cloth held by its four corners, with a box in the way.
Scene held_about(const Cuboid& box, const Pose& pose) {
  Scene scene;
  scene.cloth.pinned = {{0, 0, ""}, {24, 0, ""}, {0, 24, ""}, {24, 24, ""}};
  scene.cloth.columns = scene.cloth.rows = 25;
  scene.colliders = {{"box", box, pose, 0.12, ""}};
  return scene;
}

TEST(Overpulled, ABoxThatTautensAnEdgeDoesNotMakeItSwing) {
  // Repairs bring the springs within their limit, but the pull on them grows until a point would
  // fly from side to side in a step, if it had no added inertia.
  Scene scene = held_about({{0.529, 0.318, 0.399}},
                           {Vector3(0.568, 0.062, 0.893),
                            Eigen::Quaterniond(0.579, -0.215, -0.241, 0.749).normalized()});
  scene.cloth.orientation = Orientation::vertical;
  scene.cloth.material.ks = 731;
  scene.cloth.material.density = 56.3;
  Simulator simulator(scene);
  run_on(simulator, 6);
  EXPECT_LT(rms_velocity(simulator.state()), 0.01);
}

TEST(Overpulled, AHangingClothIsNotWhateverTheStepsThatASceneNames) {
  // A long step lets points swing, which implicit methods damp.
  for (const char* method : {"implicit_euler", "xpbd"}) {
    Scene scene = hanging();
    scene.simulation.method = method;
    scene.simulation.substeps = 1;
    Simulator simulator(scene);
    EXPECT_FALSE(yields(run_on(simulator, 3))) << method;
    EXPECT_LT(worst_stretch(simulator.cloth(), simulator.state().positions), 0.105) << method;
  }
}

TEST(Overpulled, ASmallStiffClothIsStillWhereAPinIsFar) {
  // Its steps are so short that unbounded impulses would throw it at 100 m/s, each time that the
  // limit is tried again.
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 3;
  scene.cloth.width = 0.041;
  scene.cloth.height = 0.065;
  scene.cloth.material.ks = 7e4;
  scene.cloth.material.density = 0.18;
  scene.cloth.material.damping = 27;
  scene.cloth.material.strain_limit = 0.013;
  scene.cloth.pinned = {{0, 2, ""}, {1, 2, ""}, {2, 2, ""}};
  Simulator simulator(scene);
  simulator.move_pin(2, {0.017, 0.104, 0.92});  // four times as far from the next pin, in a frame
  const StepReport report = run_on(simulator, 5);
  EXPECT_GT(report.lagging, 0);
  EXPECT_LT(rms_velocity(simulator.state()), 0.1);
}

TEST(Overpulled, AHangingClothIsNotHoweverCloseItsTolerance) {
  // Passes run out, step after step, although the limit can be met.
  Scene scene = hanging(50);
  scene.simulation.strain_tolerance = 1e-7;
  Simulator simulator(scene);
  for (int frame = 0; frame < 135; ++frame) {
    ASSERT_FALSE(yields(simulator.step())) << frame;
    ASSERT_LT(worst_stretch(simulator.cloth(), simulator.state().positions), 0.105) << frame;
  }
}

TEST(Overpulled, ABoxAboutAPinDoesNotFlingTheClothAbout) {
  // The pin's depth in it is larger than the length of springs within their limit.
  Scene scene = held_about({{0.3, 0.3, 0.3}}, {Vector3(1.04, 1.04, 1.04), {1, 0, 0, 0}});
  scene.cloth.material.ks = 2370;
  scene.cloth.material.density = 15.5;
  Simulator simulator(scene);
  double fast = 0;
  for (int frame = 0; frame < 6 * 90; ++frame) {
    simulator.step();
    fast = std::max(fast, max_speed(simulator.state()));
  }
  EXPECT_LT(fast, 15);
  EXPECT_LT(rms_velocity(simulator.state()), 0.05);
}

/// A box's tilt [rad].
class TiltedBox : public ::testing::TestWithParam<double> {};

TEST_P(TiltedBox, UnderASoftHeavyClothStretchesItLittleMoreThanItsLimit) {
  // Without friction it hangs over the corners by its limit alone: springs carry next to nothing.
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 13;
  scene.cloth.material.ks = 50;
  scene.cloth.material.density = 42000;
  ColliderSpec box;
  box.name = "box";
  box.shape = Cuboid{{0.5, 0.5, 0.3}};
  box.pose.position = Vector3(0.5, 0.5, 0.5);
  box.pose.orientation = Eigen::AngleAxisd(GetParam(), Vector3(0.7, 0.5, 0).normalized());
  box.friction = 0;
  scene.colliders = {box};
  Simulator simulator(scene);
  for (int frame = 0; frame < 10 * 90; ++frame) {
    ASSERT_LT(simulator.step().worst_stretch, 0.12) << frame;
  }
  EXPECT_GT(simulator.step().contacts, 0) << "it has slid off";
  EXPECT_LT(rms_velocity(simulator.state()), 2e-3);
}

INSTANTIATE_TEST_SUITE_P(Tilts, TiltedBox, ::testing::Values(0.2, 0.5, 0.9));

TEST(Overpulled, ARodDoesNotPassThroughStretchedCells) {
  // Cells four times as long as at rest, by pins of any strength; a rod a quarter as thick comes up
  // in the middle of a cell.
  Scene scene = hanging(10);
  scene.cloth.pin_strength = strength_range.max;
  scene.cloth.pinned.clear();
  for (const int row : {0, 9}) {
    for (int column = 0; column < 10; ++column) scene.cloth.pinned.push_back({column, row, ""});
  }
  ColliderSpec rod;
  rod.name = "rod";
  rod.shape = Capsule{3, 0.03};
  rod.friction = 0;
  rod.pose.orientation = Eigen::AngleAxisd(M_PI / 2, Vector3::UnitY());  // along x
  rod.pose.position = Vector3(0.5, 0.61, 1.5);
  scene.colliders = {rod};
  Simulator simulator(scene);
  const auto pull = [&](double share) {
    for (int i = 0; i < 20; ++i) {
      const double y = i < 10 ? -3 * share : 1 + 3 * share;
      simulator.move_pin(i, {(i % 10) / 9.0, y, 1});
    }
  };
  for (int frame = 1; frame <= 180; ++frame) {
    pull(frame / 180.0);
    simulator.step();
  }
  Pose pose = rod.pose;
  for (int frame = 0; frame < 150; ++frame) {
    pose.position.z() -= 0.006;
    simulator.move_collider(0, pose);
    simulator.step();
    ASSERT_LT(deepest_penetration(simulator), 2e-3) << frame;
  }
  // The rod has taken the cloth along.
  EXPECT_LT(simulator.state().positions.col(2).minCoeff(), 0.7);
}

}  // namespace
}  // namespace clothsim::overpulled_test
