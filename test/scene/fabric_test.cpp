// Scenes of fabric, as a whole.

#include <yaml-cpp/yaml.h>

#include "clothsim/constraints/local_cloth.h"
#include "clothsim/run/report.h"
#include "clothsim/scene/scene_yaml.h"
#include "verification/fabric_testing.h"

namespace clothsim::fabric_test {
namespace {

using namespace test;

/// A towel that hangs by two corners.
Scene hanging_towel(int side = 12) {
  Scene scene;
  scene.cloth = fabric_spec(side, side, 0.4 / (side - 1), 0.4 / (side - 1));
  scene.cloth.orientation = Orientation::vertical;
  scene.cloth.pinned = {{0, side - 1, ""}, {side - 1, side - 1, ""}};
  scene.cloth.material.fabric->internal_damping = {1e-5, 5e-3};
  return scene;
}

TEST(FabricScene, ZeroOfAnyValueWorks) {
  const auto runs = [](const std::function<void(Material&)>& change) {
    Scene scene = hanging_towel(8);
    change(scene.cloth.material);
    for (const std::string& method : method_names()) {
      scene.simulation.method = method;
      Simulator simulator(scene);
      run(simulator, 0.2);
      EXPECT_TRUE(simulator.state().positions.allFinite()) << method;
    }
    scene.simulation.method = "auto";
    Simulator simulator(scene);
    run(simulator, 0.2);
  };
  runs([](Material& m) { m.fabric->stretch_stiffness = {0, 0}; });
  runs([](Material& m) { m.fabric->stretch_stiffness = {0, 500}; });
  runs([](Material& m) { m.fabric->shear_stiffness = 0; });
  runs([](Material& m) { m.fabric->bending_stiffness = {0, 0}; });
  runs([](Material& m) { m.fabric->bending_stiffness = {0, 1e-5}; });
  runs([](Material& m) { m.fabric->internal_damping = {0, 0}; });
  runs([](Material& m) { m.fabric = Fabric(); });
  runs([](Material& m) { m.springs = {false, false, true}; });
  runs([](Material& m) { m.springs = {false, false, false}; });
  runs([](Material& m) { m.drag = {0, 0}; });
}

/// A towel in a gusty wind, with contact and grips.
Scene windy_towel(const std::string& method) {
  Scene scene = hanging_towel(40);
  scene.simulation.wind = Vector3(0, 3, 0);
  scene.simulation.gusts = 1;
  scene.simulation.method = method;
  return scene;
}

TEST(FabricScene, HasTheSameBitsFromAnyNumberOfThreads) {
  for (const char* method : {"verlet", "xpbd", "rk4", "symplectic_euler"}) {
    Scene scene = windy_towel(method);
    scene.simulation.substeps = 130;
    Simulator one(scene);
    scene.simulation.threads = 3;
    Simulator three(scene);
    run(one, 0.1);
    run(three, 0.1);
    EXPECT_EQ(one.state().positions, three.state().positions) << method;
    EXPECT_EQ(one.state().velocities, three.state().velocities) << method;
  }
}

TEST(FabricScene, GoesOnToTheSameBits) {
  for (const char* method : {"auto", "xpbd", "bdf2"}) {
    Scene scene = windy_towel(method);
    scene.cloth.columns = scene.cloth.rows = 10;
    scene.cloth.pinned = {{0, 9, ""}};
    scene.cloth.material.strain_limit = 0.02;
    Simulator simulator(scene);
    run(simulator, 0.2);
    const auto saved = simulator.save();
    run(simulator, 0.2);
    const State expected = simulator.state();
    simulator.restore(*saved);
    run(simulator, 0.2);
    EXPECT_EQ(simulator.state().positions, expected.positions) << method;
    EXPECT_EQ(simulator.state().velocities, expected.velocities) << method;
  }
}

TEST(FabricScene, KeepsItsStrainLimit) {
  Scene scene = hanging_towel();
  scene.cloth.material.fabric->stretch_stiffness = {5, 5};
  scene.cloth.material.fabric->shear_stiffness = 1;
  scene.cloth.material.strain_limit = 0.05;
  Simulator simulator(scene);
  EXPECT_LT(run(simulator, 2).worst_stretch, 0.05 + 0.01);
}

TEST(FabricScene, TakesValuesWhileItRuns) {
  Scene scene = hanging_towel();
  scene.cloth.material.damping = 10;  // to come to rest
  Simulator simulator(scene);
  run(simulator, 0.5);
  Material material = simulator.scene().cloth.material;
  material.fabric->stretch_stiffness = {50, 50};
  material.fabric->shear_stiffness = 5;
  material.fabric->internal_damping = {0, 0};
  simulator.set_material(material);
  const double soft = run(simulator, 2).worst_stretch;
  material.fabric->stretch_stiffness = {2000, 2000};
  simulator.set_material(material);
  EXPECT_GT(soft, 2 * run(simulator, 2).worst_stretch);
  material.fabric->bending_stiffness[1] = -1;
  EXPECT_THROW(simulator.set_material(material), InvalidValue);
  EXPECT_THROW(simulator.set_wind(Vector3(0, 0, std::nan(""))), InvalidValue);
  EXPECT_FALSE(simulator.scene().simulation.wind);
  simulator.set_wind(Vector3(0, 5, 0));
  run(simulator, 1);
  const Points& x = simulator.state().positions;
  EXPECT_GT(x.col(1).mean(), 0.05) << "it blows out";
}

TEST(FabricScene, TakesTheLimitOfOtherSprings) {
  // A classic cloth has springs that a fabric lacks: the limit's memory of them is void.
  Scene scene = hanging_towel();
  Material& fabric = scene.cloth.material;
  fabric.fabric->stretch_stiffness = {5, 5};
  fabric.fabric->shear_stiffness = 1;
  fabric.strain_limit = 0.05;
  Material classic = fabric;
  classic.fabric.reset();
  classic.ks = 5;
  Simulator simulator(scene);
  run(simulator, 1);
  for (const Material& next : {classic, fabric, classic}) {
    const unsigned topology = simulator.topology_seq();
    simulator.set_material(next);
    EXPECT_GT(simulator.topology_seq(), topology);
    EXPECT_LT(run(simulator, 1).worst_stretch, 0.05 + 0.01);
  }
}

TEST(FabricScene, IsCarriedByItsWeight) {
  // Two hands that move evenly carry it once it hangs still: there is no drag against the world.
  Scene scene = hanging_towel();
  scene.cloth.pinned.clear();
  scene.cloth.material.fabric->internal_damping = {1e-4, 2e-2};
  Simulator simulator(scene);
  const double weight = 9.8 * simulator.cloth().mass.sum();
  const std::vector<int> corners = {11 * 12, 12 * 12 - 1};
  Pose left, right;
  left.position = row(simulator.state().positions, corners[0]);
  right.position = row(simulator.state().positions, corners[1]);
  simulator.attach("left", left, {corners[0]});
  simulator.attach("right", right, {corners[1]});
  const auto move = [&](double seconds, double speed) {
    Vector3 sum = Vector3::Zero();
    const int frames = static_cast<int>(seconds * 90);
    for (int frame = 0; frame < frames; ++frame) {
      left.position.y() += speed / 90;
      right.position.y() += speed / 90;
      simulator.move_grip("left", left);
      simulator.move_grip("right", right);
      simulator.step();
      for (const char* hand : {"left", "right"}) {
        sum += simulator.grips().at(hand).wrench.force / frames;
      }
    }
    return sum;
  };
  move(4, 0.3);
  const Vector3 force = move(8, 0.3);  // over many swings
  EXPECT_NEAR(-force.z(), weight, 0.03 * weight);
  EXPECT_NEAR(force.y(), 0, 0.03 * weight);
}

TEST(FabricScene, IsPulledTautWithItsFullForceByFewSubstepsOfXpbd) {
  // One edge pinned, the other pulled by 1 % of the length: C22 times width times strain. Lines of
  // springs are solved at once, so that few substeps have it.
  for (const int substeps : {1, 4, 10}) {
    Scene scene;
    scene.cloth = fabric_spec(12, 25, 0.01, 0.01);
    scene.cloth.material.damping = 10;
    scene.cloth.pin_strength = 1e6;
    scene.simulation.gravity.setZero();
    scene.simulation.method = "xpbd";
    scene.simulation.substeps = substeps;
    std::vector<int> far;
    for (int column = 0; column < 12; ++column) {
      scene.cloth.pinned.push_back({column, 0, ""});
      far.push_back(24 * 12 + column);
    }
    Simulator simulator(scene);
    Pose hand;
    simulator.attach("hand", hand, far, {{}, 1e6});
    for (int frame = 0; frame < 180; ++frame) {
      hand.position.y() = 0.0024 * std::min(1.0, frame / 45.0);
      simulator.move_grip("hand", hand);
      simulator.step();
    }
    const double expected =
        scene.cloth.material.fabric->stretch_stiffness[1] * scene.cloth.width * 0.01;
    EXPECT_NEAR(-simulator.grips().at("hand").wrench.force.y(), expected, 0.02 * expected)
        << substeps;
  }
}

TEST(FabricScene, KeepsItsShapeWhereverItIsCarried) {
  // Galilean invariance: internal motion is the same in hands that move evenly and in hands at
  // rest, since internal damping depends on the cloth alone.
  const Vector3 speed(0.4, -0.2, 0.1);
  Scene scene = hanging_towel();
  scene.cloth.pinned.clear();
  Simulator still(scene), carried(scene);
  const std::vector<int> corners = {11 * 12, 12 * 12 - 1};
  for (Simulator* simulator : {&still, &carried}) {
    for (const int corner : corners) {
      Pose hand;
      hand.position = row(simulator->state().positions, corner);
      simulator->attach(std::to_string(corner), hand, {corner});
    }
  }
  State state = carried.state();
  state.velocities.rowwise() = speed.transpose();
  carried.set_state(state);
  for (int frame = 1; frame <= 90; ++frame) {
    for (const int corner : corners) {
      Pose hand;
      hand.position = row(state.positions, corner) + frame / 90.0 * speed;
      carried.move_grip(std::to_string(corner), hand);
    }
    still.step();
    carried.step();
    const Points expected = still.state().positions.rowwise() + frame / 90.0 * speed.transpose();
    ASSERT_LT(farthest(carried.state().positions, expected), 1e-9) << frame;
  }
}

/// Frequency at which the free edge of a flag turns back and forth across the wind [Hz].
double flapping_frequency(double speed) {
  Scene scene = shipped_scene("flag");
  scene.cloth.columns = 24;
  scene.cloth.rows = 16;
  scene.cloth.pinned.clear();
  for (int row = 0; row < 16; row += 3) scene.cloth.pinned.push_back({0, row, ""});
  scene.simulation.wind = Vector3(speed, 0.05 * speed, 0);
  scene.simulation.gusts = 0;
  scene.simulation.gravity.setZero();
  scene.simulation.method = "verlet";
  Simulator simulator(scene);
  run(simulator, 4);
  int turns = 0;
  double last = 0;
  constexpr int frames = 900;
  for (int frame = 0; frame < frames; ++frame) {
    simulator.step();
    const double now = point(simulator.cloth(), simulator.state().velocities, 23, 8).y();
    turns += (now > 0) != (last > 0);
    last = now;
  }
  return turns / 2.0 / (frames * simulator.frame_duration());
}

/// A cotton sheet of `side` x `side` points that falls on a ball of radius 0.2 m.
Scene sheet_over_ball(int side) {
  Scene scene =
      read_scene(YAML::Load("{cloth: {fabric: cotton_shirting, orientation: horizontal}}"));
  scene.cloth.columns = scene.cloth.rows = side;
  scene.cloth.origin = Vector3(-0.5, -0.5, 0.4);
  ColliderSpec ball;
  ball.name = "ball";
  ball.friction = 0.3;
  scene.colliders = {ball};
  return scene;
}

TEST(FabricScene, NoTriangleIsInABallWhateverTheSpacing) {
  // Corners stand off a ball that is large compared with the triangles; on a smaller ball edges and
  // faces have contacts: at 15 points the longest edge is half its radius.
  for (const int side : {15, 25, 50}) {
    const Scene scene = sheet_over_ball(side);
    Simulator simulator(scene);
    EXPECT_EQ(clearance(scene.colliders[0].shape, simulator.cloth()).faces, side == 15);
    for (int frame = 0; frame < 135; ++frame) {
      simulator.step();
      ASSERT_EQ(deepest_penetration(simulator), 0) << side << " points, frame " << frame;
    }
  }
}

TEST(FabricScene, KeepsHalfItsThicknessFromColliders) {
  // From a plane, by points, and from a box's top, by faces: the thickness of a layer is the same
  // as in self contact.
  for (const Shape& shape : {Shape(Plane{}), Shape(Cuboid{{2, 2, 0.2}})}) {
    Scene scene = sheet_over_ball(10);
    scene.cloth.thickness = 2e-3;
    const double top = std::holds_alternative<Plane>(shape) ? 0 : 0.1;
    scene.cloth.origin.z() = top + 0.01;
    scene.colliders[0].shape = shape;
    Simulator simulator(scene);
    run(simulator, 2);
    const auto heights = simulator.state().positions.col(2).array();
    EXPECT_NEAR(heights.minCoeff(), top + 2e-3, 1e-6);
    EXPECT_NEAR(heights.maxCoeff(), top + 2e-3, 1e-4);
  }
}

TEST(FabricScene, ABallPressesItTaut) {
  // Its work goes into springs that are far stiffer than the cloth is heavy: no energy from
  // nowhere. Implicit methods would solve the springs first, and stretch the cloth by half and
  // more.
  const std::vector<std::pair<double, std::string>> cases = {
      {0.05, "verlet"}, {0.2, "verlet"}, {1, "verlet"}, {0.2, "auto"}};
  for (const auto& [speed, method] : cases) {
    SCOPED_TRACE(std::to_string(speed) + ' ' + method);
    Scene scene;
    scene.cloth = fabric_spec(10, 10, 0.02, 0.02);
    Material& material = scene.cloth.material;
    material.fabric->stretch_stiffness = {5000, 5000};
    material.fabric->internal_damping = {1e-5, 1e-3};
    material.density = 0.1;
    for (int row = 0; row < 10; ++row) {
      scene.cloth.pinned.push_back({0, row, ""});
      scene.cloth.pinned.push_back({9, row, ""});
    }
    ColliderSpec ball;
    ball.name = "ball";
    ball.shape = Sphere{0.03};
    ball.pose.position = {0.09, 0.09, -0.04};
    scene.colliders = {ball};
    scene.simulation.method = method;
    Simulator simulator(scene);
    StepReport report;
    int recoveries = 0;
    const auto move = [&](double to, double at_speed) {
      while (ball.pose.position.z() != to) {
        const double left = to - ball.pose.position.z();
        ball.pose.position.z() += std::clamp(left, -at_speed / 90, at_speed / 90);
        simulator.move_collider(0, ball.pose);
        report = simulator.step();
        recoveries += report.recoveries;
      }
    };
    move(0.01, speed);  // its top 4 cm above the pins
    EXPECT_GT(report.worst_stretch, 0.1);
    EXPECT_LT(report.worst_stretch, 0.3);
    move(-0.04, 3);  // releases it
    EXPECT_EQ(recoveries, 0);
  }
}

TEST(FabricScene, AFlagFlapsAsFastAsTheWind) {
  // At 3 m/s it hangs in the wind and does not flap.
  EXPECT_LT(flapping_frequency(3), 3);
  const double slow = flapping_frequency(8);
  const double fast = flapping_frequency(16);
  EXPECT_NEAR(fast / slow, 2, 0.5) << slow << " and " << fast << " Hz";
}

}  // namespace
}  // namespace clothsim::fabric_test
