#include "clothsim/simulation/simulator.h"

#include <limits>
#include <new>
#include <stdexcept>
#include <utility>
#include <vector>

#include "clothsim/model/errors.h"
#include "clothsim/run/report.h"
#include "verification/testing.h"

namespace clothsim::simulator_test {
namespace {

using namespace test;

Scene hanging() {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 8;
  scene.cloth.pinned = {{0, 0, ""}, {7, 0, ""}};
  return scene;
}

Scene with_ball() {
  Scene scene = hanging();
  ColliderSpec ball;
  ball.name = "ball";
  ball.pose.position = Vector3(0.5, 0.5, 0.7);
  scene.colliders = {ball};
  return scene;
}

TEST(Simulator, StartsAtTheScenesStart) {
  const Simulator simulator(hanging());
  EXPECT_EQ(simulator.state().positions, simulator.cloth().rest_positions);
  EXPECT_EQ(simulator.state().time, 0);
  EXPECT_DOUBLE_EQ(simulator.frame_duration(), 1 / 90.0);
}

TEST(Simulator, RefusesABadScene) {
  Scene scene = hanging();
  scene.cloth.material.ks = -1;
  EXPECT_THROW(Simulator{scene}, InvalidValue);
}

TEST(Simulator, AFrameTakesItsTime) {
  Simulator simulator(hanging());
  const StepReport report = run(simulator, 1);
  EXPECT_NEAR(simulator.state().time, 1, 1e-12);
  EXPECT_EQ(report.method, "verlet");
  EXPECT_GE(report.substeps, 1);
  EXPECT_GE(report.sweeps, report.substeps);
  EXPECT_GT(report.worst_stretch, 0);
  EXPECT_EQ(report.contacts, 0);
}

TEST(Simulator, TakesTheSubstepsItIsTold) {
  Scene scene = hanging();
  scene.simulation.substeps = 17;
  Simulator simulator(scene);
  EXPECT_EQ(simulator.step().substeps, 17);
}

TEST(Simulator, TakesAsManySubstepsAsAreAllowed) {
  Scene scene = hanging();
  scene.simulation.substeps = max_substeps;
  Simulator simulator(scene);
  EXPECT_EQ(simulator.step().substeps, max_substeps);
}

TEST(Simulator, ADivergingFrameRollsBackCollidersToo) {
  // Contact searches in every substep, so it must not receive NaN or infinity.
  Scene scene = with_ball();
  scene.cloth.self_collision = SelfCollision::automatic;
  scene.cloth.material.ks = 1e12;
  scene.simulation.substeps = 300;
  scene.simulation.method = VelocityVerlet::name;
  Simulator simulator(scene);
  const Pose start = simulator.collider_pose(0);
  Pose target = start;
  target.position.x() += 0.1;
  simulator.move_collider(0, target);

  bool diverged = false;
  for (int frame = 0; frame < 20 && !diverged; ++frame) {
    const State last = simulator.state();
    const Pose last_pose = simulator.collider_pose(0);
    try {
      simulator.step();
    } catch (const Diverged&) {
      diverged = true;
      EXPECT_EQ(simulator.state().positions, last.positions);
      EXPECT_EQ(simulator.state().velocities, last.velocities);
      EXPECT_EQ(simulator.collider_pose(0).position, last_pose.position);
    }
  }
  EXPECT_TRUE(diverged);
}

TEST(Simulator, AutomaticSelfCollisionFollowsGravity) {
  Scene scene;
  scene.cloth.self_collision = SelfCollision::automatic;
  Simulator simulator(scene);
  EXPECT_EQ(simulator.cloth().self_collision, SelfCollision::points);
  SimulationSpec heavier = scene.simulation;
  heavier.gravity = {0, 0, -20};
  simulator.set_simulation(heavier);
  EXPECT_EQ(simulator.cloth().self_collision, SelfCollision::surface);
  scene.simulation.gravity = heavier.gravity;
  EXPECT_EQ(Simulator(scene).cloth().self_collision, SelfCollision::surface);
}

TEST(Simulator, ResetGoesBackToTheStart) {
  Simulator simulator(with_ball());
  simulator.move_collider(0, {Vector3(0, 0, 2), Eigen::Quaterniond::Identity()});
  simulator.move_pin(0, Vector3(0, 0, 3));
  run(simulator, 0.2);
  simulator.reset();
  EXPECT_EQ(simulator.state().time, 0);
  EXPECT_EQ(simulator.state().positions, simulator.cloth().rest_positions);
  EXPECT_EQ(simulator.state().velocities.norm(), 0);
  EXPECT_EQ(simulator.collider_pose(0).position, Vector3(0.5, 0.5, 0.7));
  // Also the targets of the pins.
  simulator.step();
  EXPECT_EQ(simulator.state().positions.row(0), simulator.cloth().rest_positions.row(0));
}

TEST(Simulator, ChangesMaterialBetweenFrames) {
  Simulator simulator(hanging());
  run(simulator, 0.2);
  const State before = simulator.state();
  Material material = simulator.scene().cloth.material;
  material.density *= 2;
  material.ks = 800;
  simulator.set_material(material);
  EXPECT_EQ(simulator.state().positions, before.positions) << "the cloth jumped";
  EXPECT_EQ(simulator.state().velocities, before.velocities);
  EXPECT_EQ(simulator.cloth().springs.front().stiffness, 800);
  EXPECT_NEAR(simulator.cloth().mass.sum(), 300, 1e-9);
  EXPECT_EQ(simulator.scene().cloth.material.ks, 800);
  EXPECT_EQ(simulator.topology_seq(), 0u);
  simulator.step();

  material.springs = {true, false, true};
  simulator.set_material(material);
  EXPECT_EQ(simulator.topology_seq(), 1u) << "the springs changed";
  material.strain_limit.reset();
  simulator.set_material(material);
  EXPECT_EQ(simulator.step().sweeps, 0) << "a limit that is off costs nothing";
  material.strain_limit = 0.05;
  simulator.set_material(material);
  EXPECT_GT(simulator.step().sweeps, 0);
}

TEST(Simulator, RefusedValuesChangeNothing) {
  Simulator simulator(hanging());
  simulator.step();
  Simulator twin(hanging());
  twin.step();

  Material material = simulator.scene().cloth.material;
  material.density = 500;
  material.ks = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(simulator.set_material(material), InvalidValue);
  SimulationSpec simulation = simulator.scene().simulation;
  simulation.gravity = Vector3::Zero();
  simulation.method = "magic";
  EXPECT_THROW(simulator.set_simulation(simulation), InvalidValue);
  EXPECT_EQ(simulator.scene().cloth.material.density, 150);
  EXPECT_EQ(simulator.scene().simulation.gravity.z(), -9.8);
  simulator.step();
  twin.step();
  EXPECT_EQ(simulator.state().positions, twin.state().positions);
}

TEST(Simulator, ChangesSimulationBetweenFrames) {
  Simulator simulator(hanging());
  SimulationSpec simulation = simulator.scene().simulation;
  simulation.frames_per_second = 30;
  simulation.substeps = 50;
  simulation.gravity = Vector3(0, 5, 0);
  simulator.set_simulation(simulation);
  EXPECT_EQ(simulator.step().substeps, 50);
  EXPECT_NEAR(simulator.state().time, 1 / 30.0, 1e-15);
  EXPECT_GT(simulator.state().velocities(63, 1), 0.1);
  EXPECT_NEAR(simulator.state().velocities(63, 2), 0, 1e-12);
}

TEST(Simulator, SaysWhereNewtonsMethodRanOut) {
  for (const std::string method : {"implicit_euler", "bdf2"}) {
    Scene scene = hanging();
    scene.cloth.material.strain_limit.reset();
    scene.simulation.method = method;
    scene.simulation.substeps = 2;
    StepReport report = Simulator(scene).step();
    EXPECT_EQ(report.ran_out, 0);
    EXPECT_EQ(report.reasons.all(), std::set{Reason::named_by_scene});

    NewtonSolver::Parameters few;
    few.max_iterations = 1;
    few.tolerance = 1e-9;
    if (method == "bdf2") {
      scene.simulation.method_parameters = Bdf2::Parameters{few};
    } else {
      scene.simulation.method_parameters = ImplicitEuler::Parameters{few};
    }
    report = Simulator(scene).step();
    EXPECT_EQ(report.ran_out, 2);
    EXPECT_TRUE(report.reasons.has(Reason::newton_unconverged));
    EXPECT_EQ(report.reasons.text(),
              "named by the scene; Newton's method ran out of iterations in 2 of 2 substeps");
  }
}

TEST(Simulator, ChangesMethodAndItsParametersBetweenFrames) {
  Scene scene = hanging();
  scene.cloth.material.strain_limit.reset();
  scene.simulation.method = "xpbd";
  Simulator simulator(scene);
  Simulator twin(scene);
  EXPECT_EQ(simulator.step().method, "xpbd");
  twin.step();

  SimulationSpec simulation = simulator.scene().simulation;
  Xpbd::Parameters parameters;
  parameters.iterations = 0;
  simulation.method_parameters = parameters;
  try {
    simulator.set_simulation(simulation);
    FAIL() << "accepted";
  } catch (const InvalidValue& error) {
    EXPECT_EQ(error.key(), (std::vector<std::string>{"method_parameters", "iterations"}));
  }
  parameters.iterations = 30;
  simulation.method_parameters = parameters;
  simulator.set_simulation(simulation);
  simulator.step();
  twin.step();
  EXPECT_GT((simulator.state().positions - twin.state().positions).norm(), 1e-8) << "not taken";

  simulation.method = "bdf2";
  EXPECT_THROW(simulator.set_simulation(simulation), InvalidValue) << "parameters of another";
  simulation.method_parameters = {};
  simulator.set_simulation(simulation);
  EXPECT_EQ(simulator.step().method, "bdf2");
}

TEST(Simulator, PinsArriveExactly) {
  Simulator simulator(hanging());
  const Vector3 target(0.9912, -0.005, 1.003);
  simulator.move_pin(1, target);
  simulator.step();
  EXPECT_EQ(Vector3(simulator.state().positions.row(7).transpose()), target);
  EXPECT_EQ(simulator.state().velocities.row(7).norm(), 0);
  EXPECT_EQ(simulator.state().positions.row(0), simulator.cloth().rest_positions.row(0));
}

TEST(Simulator, CollidersArriveExactlyAndStay) {
  Simulator simulator(with_ball());
  const Pose target{Vector3(0.3, 0.1, 0.45),
                    Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vector3::UnitX()))};
  simulator.move_collider(0, target);
  simulator.step();
  EXPECT_EQ(simulator.collider_pose(0).position, target.position);
  simulator.step();
  EXPECT_EQ(simulator.collider_pose(0).position, target.position);
  simulator.place_collider(0, Pose{Vector3(5, 5, 5), Eigen::Quaterniond::Identity()});
  EXPECT_EQ(simulator.collider_pose(0).position, Vector3(5, 5, 5));
}

TEST(Simulator, AColliderThatIsOffIsNotThere) {
  Scene scene = with_ball();
  scene.simulation.method = VelocityVerlet::name;
  scene.simulation.substeps = 20;
  scene.colliders[0].friction = 0.5;
  Simulator on(scene);
  scene.colliders[0].enabled = false;
  Simulator off(scene);
  EXPECT_FALSE(off.collider_enabled(0));
  scene.colliders.clear();
  Simulator without(scene);
  ASSERT_GT(run(on, 0.5).contacts, 0) << "it meets the ball";
  EXPECT_EQ(run(off, 0.5).contacts, 0);
  run(without, 0.5);
  EXPECT_EQ(off.state().positions, without.state().positions);

  // Once it is off, the cloth leaves it, and falls as from there with nothing below.
  on.enable_collider(0, false);
  EXPECT_EQ(on.step().contacts, 0);
  without.set_state(on.state());
  on.set_state(on.state());
  run(on, 0.5);
  run(without, 0.5);
  EXPECT_EQ(on.state().positions, without.state().positions);

  on.reset();
  EXPECT_TRUE(on.collider_enabled(0));
  off.enable_collider(0, true);
  off.reset();
  EXPECT_FALSE(off.collider_enabled(0));
}

TEST(Simulator, AColliderTurnedOnWithinTheClothPushesItOutGently) {
  for (const double height : {1.0, 1.15}) {  // of its middle: in the cloth, and just above it
    Scene scene = with_ball();
    scene.cloth.columns = scene.cloth.rows = 15;
    scene.cloth.pinned.clear();
    scene.simulation.gravity.setZero();
    scene.colliders[0].pose.position.z() = height;
    scene.colliders[0].enabled = false;
    Simulator simulator(scene);
    run(simulator, 0.1);
    ASSERT_LT(max_speed(simulator.state()), 1e-9);
    ASSERT_EQ(deepest_penetration(simulator), 0) << "nothing is in what is off";

    simulator.enable_collider(0, true);
    ASSERT_GT(deepest_penetration(simulator), 0.04);
    double speed = 0;
    for (int frame = 0; frame < 90; ++frame) {
      EXPECT_EQ(simulator.step().recoveries, 0);
      speed = std::max(speed, max_speed(simulator.state()));
    }
    EXPECT_LT(speed, 3) << height;  // it pushes at 2 m/s
    EXPECT_EQ(deepest_penetration(simulator), 0) << height;
  }
}

TEST(Simulator, PlacesThatCannotBeAreRefused) {
  Simulator simulator(with_ball());
  simulator.attach("hand", Pose{}, {40});
  const std::vector<double> memory = simulator.memory();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Pose turned;
  turned.orientation.coeffs() *= 2;
  for (const Pose& bad : {Pose{Vector3(0, nan, 0), Eigen::Quaterniond::Identity()},
                          Pose{Vector3(0, 0, 2e12), Eigen::Quaterniond::Identity()},
                          Pose{Vector3::Zero(), Eigen::Quaterniond(nan, 0, 0, 0)}, turned}) {
    EXPECT_THROW(simulator.move_collider(0, bad), InvalidValue);
    EXPECT_THROW(simulator.place_collider(0, bad), InvalidValue);
    EXPECT_THROW(simulator.move_grip("hand", bad), InvalidValue);
    EXPECT_THROW(simulator.attach("other", bad, {41}), InvalidValue);
  }
  EXPECT_THROW(simulator.move_pin(0, Vector3(nan, 0, 0)), InvalidValue);
  EXPECT_EQ(simulator.memory(), memory);
  EXPECT_EQ(simulator.collider_pose(0).position, with_ball().colliders[0].pose.position);
  EXPECT_EQ(simulator.grips().size(), 1u);
  simulator.step();
}

TEST(Simulator, AResetForgetsWhatHasDisturbedIt) {
  const std::vector<double> fresh = Simulator(with_ball()).memory();
  Simulator simulator(with_ball());
  simulator.place_collider(0, Pose{});
  simulator.attach("hand", Pose{}, {40});
  simulator.set_material(with_ball().cloth.material);
  EXPECT_NE(simulator.memory(), fresh);
  simulator.reset();
  EXPECT_EQ(simulator.memory(), fresh);
}

TEST(Simulator, IsMovedWithAllItHas) {
  std::vector<Simulator> simulators;
  for (int k = 0; k < 3; ++k) simulators.emplace_back(with_ball());
  simulators.front().step();
  simulators.back() = std::move(simulators.front());
  EXPECT_GT(simulators.back().state().time, 0);
  simulators.back().step();
}

TEST(Simulator, UnknownIndicesThrow) {
  Simulator simulator(with_ball());
  EXPECT_THROW(simulator.enable_collider(1, false), std::out_of_range);
  EXPECT_THROW(simulator.move_collider(1, Pose{}), std::out_of_range);
  EXPECT_THROW(simulator.place_collider(-1, Pose{}), std::out_of_range);
  EXPECT_THROW(simulator.move_pin(2, Vector3::Zero()), std::out_of_range);
}

TEST(Simulator, IsBrokenOffBetweenSubsteps) {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 8;
  scene.cloth.pinned = {{0, 0, ""}};
  scene.simulation.substeps = 10;
  Simulator simulator(scene), twin(scene);
  for (Simulator* s : {&simulator, &twin}) s->step();
  int asked = 0;
  simulator.set_interrupt([&] { return ++asked == 4; });
  EXPECT_THROW(simulator.step(), Interrupted);
  EXPECT_EQ(asked, 4) << "asked before each substep";
  EXPECT_EQ(simulator.state().positions, twin.state().positions);
  EXPECT_EQ(simulator.state().velocities, twin.state().velocities);
  EXPECT_EQ(simulator.state().time, twin.state().time);

  // It goes on as from a state without a memory. The interrupt is kept when a scene is loaded.
  twin.set_state(twin.state());
  simulator.step();
  twin.step();
  EXPECT_EQ(simulator.state().positions, twin.state().positions);
  simulator.load(scene);
  asked = 0;
  EXPECT_THROW(simulator.step(), Interrupted);
}

TEST(Simulator, KeepsTheFrameBeforeAfterAnExceptionInASubstep) {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 8;
  scene.cloth.pinned = {{0, 0, ""}};
  scene.colliders = {
      {"ball", Sphere{0.1}, {Vector3(5, 0, 1), Eigen::Quaterniond::Identity()}, 0, ""}};
  scene.colliders[0].body.emplace();
  scene.simulation.substeps = 10;
  Simulator simulator(scene);
  simulator.step();
  const State before = simulator.state();
  const Vector3 ball = simulator.collider_pose(0).position;
  int asked = 0;
  simulator.set_interrupt([&]() -> bool {
    if (++asked == 4) throw std::bad_alloc();
    return false;
  });
  EXPECT_THROW(simulator.step(), std::bad_alloc);
  EXPECT_EQ(simulator.state().positions, before.positions);
  EXPECT_EQ(simulator.state().time, before.time);
  EXPECT_EQ(simulator.collider_pose(0).position, ball);
  simulator.step();
  EXPECT_NE(simulator.collider_pose(0).position, ball);
}

}  // namespace
}  // namespace clothsim::simulator_test
