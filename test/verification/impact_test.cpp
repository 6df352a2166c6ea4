// Fast colliders: nothing tunnels, for any step.

#include <cmath>

#include "clothsim/run/report.h"
#include "verification/testing.h"

namespace clothsim::impact_test {
namespace {

using namespace test;

/// Speed [m/s], strain limit, substeps (0: auto).
using Impact = std::tuple<double, bool, int>;

class FastSphere : public ::testing::TestWithParam<Impact> {};

TEST_P(FastSphere, LeavesNoPointBehindIt) {
  // A ball of radius 0.2 m driven up through the middle of a free sheet, from 0.5 m below it to at
  // least 0.3 m above it. A point less than half a radius off its axis may slip off its side, never
  // through it: it is above the ball's middle or beside it. Others may also close in behind it.
  const auto& [speed, limited, substeps] = GetParam();
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 25;
  scene.cloth.origin = Vector3(-0.5, -0.5, 0);
  scene.cloth.material.ks = 50;  // soft enough for one substep a frame
  if (!limited) scene.cloth.material.strain_limit.reset();
  scene.simulation.gravity = Vector3::Zero();
  if (substeps > 0) scene.simulation.substeps = substeps;
  ColliderSpec ball;
  ball.name = "ball";
  ball.pose.position = Vector3(0.01, 0.02, -0.5);
  scene.colliders = {ball};
  Simulator simulator(scene);

  const double radius = 0.2;
  const double frame_path = speed * simulator.frame_duration();
  const int frames = static_cast<int>(std::ceil(0.8 / frame_path));
  Pose pose = ball.pose;
  for (int frame = 1; frame <= frames; ++frame) {
    pose.position.z() += frame_path;
    simulator.move_collider(0, pose);
    simulator.step();
    const Points& x = simulator.state().positions;
    ASSERT_TRUE(x.allFinite());
    ASSERT_LE(deepest_penetration(simulator), 0) << "frame " << frame;
    for (int i = 0; i < x.rows(); ++i) {
      const Vector3 start =
          simulator.cloth().rest_positions.row(i).transpose() - ball.pose.position;
      if (start.head<2>().norm() > radius / 2) continue;
      const Vector3 p = x.row(i).transpose() - pose.position;
      ASSERT_TRUE(p.z() >= 0 || p.head<2>().norm() >= radius)
          << "point " << i << ", frame " << frame;
    }
  }
  // The middle was carried along.
  EXPECT_GT(simulator.state().positions(12 * 25 + 12, 2), pose.position.z());
}

INSTANTIATE_TEST_SUITE_P(Speeds, FastSphere,
                         ::testing::Combine(::testing::Values(1.0, 10.0, 100.0), ::testing::Bool(),
                                            ::testing::Values(0, 1)));

class FastPlane : public ::testing::TestWithParam<std::tuple<double, bool>> {};

TEST_P(FastPlane, TakesTheWholeSheetAlong) {
  // A plane driven up through a sheet from 0.5 m below: every point ends on it with its speed.
  const auto& [speed, two_sided] = GetParam();
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 10;
  scene.cloth.origin = Vector3(-0.5, -0.5, 0);
  scene.simulation.gravity = Vector3::Zero();
  ColliderSpec plane;
  plane.name = "plane";
  plane.shape = Plane{two_sided};
  plane.pose.position = Vector3(0, 0, -0.5);
  scene.colliders = {plane};
  Simulator simulator(scene);
  const double frame_path = speed * simulator.frame_duration();
  const int frames = static_cast<int>(std::ceil(1.5 / frame_path));
  Pose pose = plane.pose;
  for (int frame = 1; frame <= frames; ++frame) {
    pose.position.z() += frame_path;
    simulator.move_collider(0, pose);
    simulator.step();
    ASSERT_GE(simulator.state().positions.col(2).minCoeff(), pose.position.z()) << frame;
  }
  // 1 % of the way is the loss by drag of a sheet that is pushed by steps.
  EXPECT_LE(simulator.state().positions.col(2).maxCoeff(),
            pose.position.z() + surface_offset + 0.01 * frame_path);
  EXPECT_NEAR(simulator.state().velocities.col(2).mean(), speed, 0.01 * speed);
}

/// A row of two points that hangs on two pinned ones, with a plane between.
Scene tied_down(bool two_sided) {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 2;
  scene.cloth.width = scene.cloth.height = 0.1;
  scene.cloth.orientation = Orientation::vertical;
  scene.cloth.origin = Vector3::Zero();
  scene.cloth.pinned = {{0, 0, ""}, {1, 0, ""}};
  ColliderSpec plane;
  plane.name = "plane";
  plane.shape = Plane{two_sided};
  plane.pose.position = Vector3(0, 0, 0.05);
  scene.colliders = {plane};
  return scene;
}

TEST(Impact, APlaneLiftsWhatIsTiedDown) {
  // Springs at their limit, 0.11 m, pull the free row back through the plane; beyond, it yields.
  for (const bool two_sided : {false, true}) {
    for (const double speed : {0.1, 0.15, 0.2, 0.25, 0.3, 1.0, 1.25, 3.0}) {  // [m/s]
      SCOPED_TRACE(speed);
      const Scene scene = tied_down(two_sided);
      Simulator simulator(scene);
      Pose pose = scene.colliders[0].pose;
      const double seconds = 0.15 / speed + 2;
      for (int frame = 0; frame < 90 * seconds; ++frame) {
        const double way = speed * simulator.frame_duration();
        pose.position.z() = std::min(pose.position.z() + way, 0.2);
        simulator.move_collider(0, pose);
        simulator.step();
        for (const int free : {2, 3}) {
          ASSERT_GE(simulator.state().positions(free, 2), pose.position.z()) << frame;
        }
        ASSERT_LT(max_speed(simulator.state()), 2 * speed + 5);
      }
      EXPECT_LT(max_speed(simulator.state()), 0.1) << "it is tried again and again";
    }
  }
}

TEST(Impact, PinsThatLagGoOnToTheSameBits) {
  const Scene scene = tied_down(false);
  Simulator simulator(scene);
  const Pose lifted{Vector3(0, 0, 0.2), Eigen::Quaterniond::Identity()};
  simulator.move_collider(0, lifted);
  run(simulator, 2);
  ASSERT_GT(simulator.step().lagging, 0);
  Simulator other(scene);
  other.place_collider(0, lifted);
  other.set_state(simulator.state(), simulator.memory());
  for (int frame = 0; frame < 360; ++frame) {
    simulator.step();
    other.step();
    ASSERT_TRUE(simulator.state().positions == other.state().positions) << frame;
  }
}

TEST(Impact, AColliderGoesNoFartherThanItsTargetWhereTheFrameHasGotLonger) {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 4;
  scene.simulation.gravity = Vector3::Zero();
  scene.colliders.resize(1);
  scene.colliders[0].name = "ball";
  scene.colliders[0].pose.position = Vector3(0.5, 0.5, 0.2);
  Simulator simulator(scene);
  const double height = simulator.state().positions(0, 2);
  ASSERT_GT(height, 0.9);
  const Pose target{Vector3(0.5, 0.5, 0.3), Eigen::Quaterniond::Identity()};  // 0.5 m below it
  simulator.move_collider(0, target);
  SimulationSpec slower = scene.simulation;
  slower.frames_per_second /= 10;
  simulator.set_simulation(slower);
  simulator.step();
  EXPECT_EQ(simulator.collider_pose(0).position, target.position);
  EXPECT_EQ(simulator.state().positions.col(2).maxCoeff(), height);
}

class RowOfPoints : public ::testing::TestWithParam<double> {};

TEST_P(RowOfPoints, GoOnTogetherWithoutSprings) {
  // Ten points in a row. The first runs into the third, and that into its next: adjacent points do
  // not touch. They go on together, as closely as the passes converge.
  const double width = GetParam();
  Scene scene;
  scene.cloth.columns = 10;
  scene.cloth.rows = 1;
  scene.cloth.width = width;  // 21 mm apart and more
  scene.cloth.height = 0.02;
  scene.cloth.thickness = 0.01;
  scene.cloth.self_collision = SelfCollision::points;
  scene.cloth.material.springs = {false, false, false};
  scene.cloth.material.strain_limit.reset();
  scene.cloth.material.damping = 0;
  scene.simulation.gravity = Vector3::Zero();
  Simulator simulator(scene);
  State state = simulator.state();
  state.velocities(0, 0) = 1;
  simulator.set_state(state);
  run(simulator, 0.5);
  EXPECT_NEAR(simulator.state().velocities.col(0).sum(), 1, 1e-12);
  const auto apart = [&](int a, int b) {
    return std::abs(simulator.state().velocities(a, 0) - simulator.state().velocities(b, 0));
  };
  for (int i = 0; i + 2 < 10; i += 2) EXPECT_LT(apart(i, i + 2), 2e-3) << i;
}

INSTANTIATE_TEST_SUITE_P(Widths, RowOfPoints,
                         ::testing::Values(0.189, 0.19, 0.1905, 0.195, 0.2, 0.21));

INSTANTIATE_TEST_SUITE_P(Speeds, FastPlane,
                         ::testing::Combine(::testing::Values(1.0, 10.0, 100.0),
                                            ::testing::Bool()));

}  // namespace
}  // namespace clothsim::impact_test
