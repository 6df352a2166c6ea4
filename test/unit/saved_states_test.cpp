// Copies of the whole state of motion, which can be restored.

#include <functional>
#include <vector>

#include "clothsim/model/errors.h"
#include "state_testing.h"
#include "verification/testing.h"

namespace clothsim::saved_states_test {
namespace {

using namespace test;

TEST(SavedStates, BringBackCollidersAndPinsToo) {
  Simulator simulator(busy("auto"));
  const auto carry = [&](double x) {
    simulator.move_collider(0, {Vector3(0.5 + x, 0.5, 0.75), Eigen::Quaterniond::Identity()});
    simulator.move_pin(0, Vector3(-x, 0, 1));
    simulator.step();
  };
  for (int i = 0; i < 30; ++i) carry(0.002 * i);
  const auto saved = simulator.save();
  const State state = simulator.state();
  const Pose pose = simulator.collider_pose(0);
  const auto go_on = [&] {
    for (int i = 30; i < 60; ++i) carry(0.002 * i);
  };
  go_on();
  const State expected = simulator.state();

  simulator.restore(*saved);
  expect_same(simulator.state(), state);
  EXPECT_EQ(simulator.collider_pose(0).position, pose.position);
  go_on();
  expect_same(simulator.state(), expected);
}

TEST(SavedStates, KeepThatAColliderPushesTheClothOut) {
  Scene scene = busy("verlet");
  scene.cloth.material.strain_limit = 0.1;  // tension sets the substeps, but not during the push
  Simulator simulator(scene);
  run(simulator, once);
  const Vector3 inside = simulator.state().positions.row(55).transpose();
  simulator.place_collider(0, {inside, Eigen::Quaterniond::Identity()});
  simulator.step();
  const auto saved = simulator.save();
  const auto substeps = [&] {
    std::vector<int> counts;
    for (int frame = 0; frame < 5; ++frame) counts.push_back(simulator.step().substeps);
    return counts;
  };
  const std::vector<int> expected = substeps();
  const State state = simulator.state();
  simulator.restore(*saved);
  EXPECT_EQ(substeps(), expected);
  expect_same(simulator.state(), state);
}

TEST(SavedStates, KeepWhichCollidersAreOn) {
  Simulator simulator(busy("auto"));
  run(simulator, once);
  const auto on = simulator.save();
  run(simulator, more);
  const State expected = simulator.state();
  simulator.restore(*on);
  simulator.enable_collider(0, false);
  const auto off = simulator.save();
  run(simulator, more);
  const State without = simulator.state();
  EXPECT_NE(without.positions, expected.positions);

  simulator.restore(*on);
  EXPECT_TRUE(simulator.collider_enabled(0));
  run(simulator, more);
  expect_same(simulator.state(), expected);
  simulator.restore(*off);
  EXPECT_FALSE(simulator.collider_enabled(0));
  run(simulator, more);
  expect_same(simulator.state(), without);
}

TEST(SavedStates, OfAClothFasterThanAnyMayBeGivenComeBack) {
  Scene scene = swinging();
  scene.cloth.pinned.clear();
  scene.simulation.gravity = Vector3(0, 0, -1e5);
  Simulator simulator(scene);
  run(simulator, 0.1);
  ASSERT_GT(max_speed(simulator.state()), max_given_speed);
  const auto saved = simulator.save();
  run(simulator, 0.1);
  const State expected = simulator.state();
  simulator.restore(*saved);
  run(simulator, 0.1);
  expect_same(simulator.state(), expected);
}

TEST(SavedStates, SurviveAChangeOfMaterial) {
  Simulator simulator(busy("auto"));
  run(simulator, once);
  const auto saved = simulator.save();
  const State state = simulator.state();
  Material material = simulator.scene().cloth.material;
  material.springs = {true, false, true};
  simulator.set_material(material);
  run(simulator, more);
  simulator.restore(*saved);
  expect_same(simulator.state(), state);
  EXPECT_EQ(simulator.scene().cloth.material.springs[1], false);
  simulator.step();
}

TEST(SavedStates, OfAnotherMaterialGoOnWithoutHistory) {
  const auto stiffer = [](Simulator& simulator) {
    Material material = simulator.scene().cloth.material;
    material.ks *= 2;
    simulator.set_material(material);
  };
  Simulator simulator(swinging());
  run(simulator, once);
  const auto saved = simulator.save();
  const State state = simulator.state();
  stiffer(simulator);
  simulator.step();
  const State expected = simulator.state();
  simulator.restore(*saved);
  expect_same(simulator.state(), state);
  simulator.step();
  expect_same(simulator.state(), expected);
}

TEST(SavedStates, OfAnotherSceneAreRefused) {
  Simulator simulator(busy("auto"));
  run(simulator, once);
  const auto saved = simulator.save();
  const auto expect_refused = [&](const auto& change) {
    Scene scene = busy("auto");
    change(scene);
    Simulator other(scene);
    const std::vector<double> memory = other.memory();
    EXPECT_THROW(other.restore(*saved), InvalidValue);
    EXPECT_EQ(other.memory(), memory);
  };
  expect_refused([](Scene& other) {
    other.cloth.columns = 20;  // as many points
    other.cloth.rows = 5;
  });
  expect_refused([](Scene& other) { other.cloth.width *= 2; });
  expect_refused([](Scene& other) {  // more rows, and fewer, of the same cells
    other.cloth.rows = 19;
    other.cloth.height *= 2;
  });
  expect_refused([](Scene& other) {
    other.cloth.rows = 4;
    other.cloth.height /= 3;
  });
  expect_refused([](Scene& other) { other.cloth.pinned = {{9, 0, ""}}; });
  expect_refused([](Scene& other) { other.colliders.clear(); });
  expect_refused([](Scene& other) { other.colliders[0].shape = Cuboid(); });
  expect_refused([](Scene& other) { other.colliders[0].shape = Sphere{0.1}; });
  Simulator(busy("auto")).restore(*saved);
}

TEST(SavedStates, OfACollidersBodyAreRefusedWithoutThatBody) {
  Scene scene = busy("auto");
  scene.colliders[0].body.emplace().mass = 0.1;
  Simulator other(busy("auto"));
  other.attach("hand", Pose(), {55});
  const auto saved = Simulator(scene).save();
  EXPECT_THROW(other.restore(*saved), InvalidValue);
  EXPECT_EQ(other.grips().count("hand"), 1u);  // nothing changed
}

TEST(SavedStates, OfAnotherThicknessOrFrictionGoOnByThoseOfTheSimulator) {
  // In a simulator whose scene has these values, and in one where they were changed live.
  const std::vector<std::function<void(Scene&)>> changes = {
      [](Scene& scene) { scene.cloth.thickness *= 1.5; },
      [](Scene& scene) { scene.cloth.friction = 0.9; },
      [](Scene& scene) { scene.colliders[0].friction = 0.1; }};
  Simulator unchanged(busy("auto"));
  run(unchanged, once);
  const auto saved = unchanged.save();
  const State state = unchanged.state();
  for (const auto& change : changes) {
    Scene scene = busy("auto");
    change(scene);
    Simulator other(scene), changed(busy("auto"));
    changed.set(live_values(scene));
    for (Simulator* simulator : {&other, &changed}) {
      simulator->restore(*saved);
      expect_same(simulator->state(), state);
      EXPECT_EQ(simulator->cloth().thickness, scene.cloth.thickness);
      EXPECT_EQ(simulator->cloth().friction, scene.cloth.friction);
      EXPECT_EQ(simulator->scene().colliders[0].friction, scene.colliders[0].friction);
      run(*simulator, once);
    }
    expect_same(other.state(), changed.state());
  }
}

TEST(SavedStates, OfThinnerClothWhosePointsTouchGoOnWhereItIsThick) {
  Scene scene = shipped_scene("self_collision");
  scene.cloth.columns = scene.cloth.rows = 20;
  scene.cloth.self_collision = SelfCollision::points;
  Simulator simulator(scene);
  run(simulator, 1.5);
  const auto saved = simulator.save();
  LiveSpec live = live_values(scene);
  live.thickness *= 1.6;  // former contacts are neighbours now
  simulator.set(live);
  simulator.restore(*saved);
  EXPECT_EQ(simulator.cloth().thickness, live.thickness);
  run(simulator, 0.1);
}

TEST(SavedStates, OfAnotherDensityGoOnWithoutTheImpulsesOfItsPairs) {
  Scene scene = shipped_scene("self_collision");
  scene.cloth.columns = scene.cloth.rows = 12;
  scene.cloth.self_collision = SelfCollision::surface;
  Simulator simulator(scene);
  run(simulator, 1.5);
  const auto saved = simulator.save();
  const std::size_t all = simulator.memory().size();
  simulator.restore(*saved);
  EXPECT_EQ(simulator.memory().size(), all);
  Material material = scene.cloth.material;
  material.density *= 2;
  simulator.set_material(material);
  simulator.restore(*saved);
  EXPECT_LT(simulator.memory().size(), all);
}

TEST(SavedStates, OfAnotherDensityOrGravityAreJudgedAnew) {
  for (const bool heavier : {true, false}) {
    Scene scene;
    scene.cloth.columns = scene.cloth.rows = 10;
    scene.simulation.method = "verlet";
    scene.simulation.substeps = 8;
    Simulator simulator(scene);
    run(simulator, 0.2);
    const auto saved = simulator.save();
    Material material = scene.cloth.material;
    SimulationSpec simulation = scene.simulation;
    if (heavier) {
      material.density *= 20;
    } else {
      simulation.gravity *= 6;
    }
    simulator.set(material, simulation);
    simulator.restore(*saved);
    EXPECT_EQ(run(simulator, 0.5).recoveries, 0);
  }
}

TEST(SavedStates, SendCollidersNoFartherThanTheirTargetInFramesOfAnotherLength) {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 4;
  scene.simulation.gravity = Vector3::Zero();
  ColliderSpec ball;
  ball.name = "ball";
  ball.pose.position = Vector3(0.5, 0.5, 0.2);
  scene.colliders = {ball};
  Simulator simulator(scene);
  const double height = simulator.state().positions(0, 2);
  const Pose target{Vector3(0.5, 0.5, 0.3), Eigen::Quaterniond::Identity()};  // far below it
  simulator.move_collider(0, target);
  const auto saved = simulator.save();
  SimulationSpec slower = scene.simulation;
  slower.frames_per_second /= 10;
  simulator.set_simulation(slower);
  simulator.restore(*saved);
  simulator.step();
  EXPECT_EQ(simulator.collider_pose(0).position, target.position);
  EXPECT_EQ(simulator.state().positions.col(2).maxCoeff(), height);
}

}  // namespace
}  // namespace clothsim::saved_states_test
