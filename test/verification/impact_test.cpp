// Fast colliders: nothing tunnels, whatever the step.

#include <cmath>

#include "clothsim/simulation/report.h"
#include "verification/testing.h"

namespace clothsim {
namespace {

using namespace testing;

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
  // 1 % of the way is what drag takes from a sheet that is pushed by steps.
  EXPECT_LE(simulator.state().positions.col(2).maxCoeff(),
            pose.position.z() + surface_offset + 0.01 * frame_path);
  EXPECT_NEAR(simulator.state().velocities.col(2).mean(), speed, 0.01 * speed);
}

INSTANTIATE_TEST_SUITE_P(Speeds, FastPlane,
                         ::testing::Combine(::testing::Values(1.0, 10.0, 100.0),
                                            ::testing::Bool()));

}  // namespace
}  // namespace clothsim
