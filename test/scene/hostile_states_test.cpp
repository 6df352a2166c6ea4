// States that were set and cannot be solved: taken back and reported, after the same count of work
// everywhere.

#include <string>

#include "clothsim/model/errors.h"
#include "hanging.h"

namespace clothsim::hostile_states_test {
namespace {

using namespace test;

struct Hostile {
  const char* name;
  SelfCollision self_collision;
  double size;  // of the box with the random points, to either side [m]
};

/// A cloth over a sphere.
Scene scene_of(const Hostile& hostile) {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 30;
  scene.cloth.self_collision = hostile.self_collision;
  scene.cloth.thickness = 0.01;
  scene.colliders = {
      {"ball", Sphere{0.2}, {Vector3(0.5, 0.5, -0.3), Eigen::Quaterniond::Identity()}, 0.3, ""}};
  return scene;
}

/// Sets every point somewhere in the box, at up to 999 m/s along each axis.
void strew(Simulator& simulator, double size) {
  State state = simulator.state();
  const int count = simulator.cloth().num_points();
  state.positions = random_points(count, size, 1);
  state.velocities = random_points(count, 999, 2);
  simulator.set_state(state);
}

/// The message of step() when it gives up, within some frames; empty if it does not.
std::string refusal(Simulator& simulator) {
  try {
    for (int frame = 0; frame < 20; ++frame) simulator.step();
  } catch (const Diverged& error) {
    return error.what();
  }
  return "";
}

class HostileState : public ::testing::TestWithParam<Hostile> {};

TEST_P(HostileState, IsTakenBackAndToldAfterTheSameWorkWithAnyThreads) {
  const Hostile hostile = GetParam();
  Scene scene = scene_of(hostile);
  Simulator simulator(scene);
  strew(simulator, hostile.size);
  const std::string told = refusal(simulator);
  EXPECT_NE(told.find("asks for more than can be solved"), std::string::npos) << told;

  // The last good frame is kept, and the next call gives the same answer.
  const State kept = simulator.state();
  EXPECT_TRUE(kept.positions.allFinite());
  EXPECT_EQ(refusal(simulator), told);
  EXPECT_EQ(simulator.state().positions, kept.positions);

  scene.simulation.threads = 2;
  Simulator in_two(scene);
  strew(in_two, hostile.size);
  EXPECT_EQ(refusal(in_two), told);
  EXPECT_EQ(in_two.state().positions, kept.positions);

  simulator.reset();
  EXPECT_NO_THROW(run(simulator, 0.1));
}

INSTANTIATE_TEST_SUITE_P(Strewn, HostileState,
                         ::testing::Values(Hostile{"OnASphere", SelfCollision::off, 999},
                                           Hostile{"OnASphereInABox", SelfCollision::off, 1},
                                           Hostile{"Points", SelfCollision::points, 999},
                                           Hostile{"PointsInABox", SelfCollision::points, 0.1},
                                           Hostile{"PointsInOnePlace", SelfCollision::points, 1e-4},
                                           Hostile{"Surface", SelfCollision::surface, 999},
                                           Hostile{"SurfaceInABox", SelfCollision::surface, 1},
                                           Hostile{"SurfaceInOnePlace", SelfCollision::surface,
                                                   1e-4}),
                         [](const auto& tested) { return tested.param.name; });

TEST(HostileStates, CalmOnesAreFollowedThroughAShock) {
  // A ball at 100 m/s takes several times the work that is allowed after a set state.
  Scene scene = scene_of({"", SelfCollision::surface, 0});
  scene.colliders[0].pose.position.z() = -2;
  Simulator simulator(scene);
  State slow = simulator.state();
  simulator.set_state(slow);
  simulator.step();
  for (int frame = 1; frame <= 4; ++frame) {
    simulator.move_collider(0,
                            {Vector3(0.5, 0.5, -2 + frame / 0.9), Eigen::Quaterniond::Identity()});
    EXPECT_NO_THROW(simulator.step()) << frame;
  }
}

}  // namespace
}  // namespace clothsim::hostile_states_test
