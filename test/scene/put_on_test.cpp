// Colliders that are turned on where a cloth is: it leaves them in one piece, soon, and slowly
// unless something thin pierces it.

#include <algorithm>
#include <cmath>
#include <optional>

#include "clothsim/run/report.h"
#include "verification/testing.h"

namespace clothsim::put_on_test {
namespace {

using namespace test;

/// A cloth of 30 x 30 points that hangs by its corners, or lies on a floor, with a collider in its
/// middle that is off.
Scene with(const Shape& shape, double ks, double density, bool lies, bool upright = false) {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 30;
  scene.cloth.self_collision = SelfCollision::surface;
  scene.cloth.material.ks = ks;
  scene.cloth.material.density = density;
  const double height = lies ? 0 : 0.5;
  scene.cloth.origin = {0, 0, height + 0.006};
  ColliderSpec body{"body", shape, {Vector3(0.5, 0.5, height + 0.02)}, 0.3, ""};
  if (!upright) body.pose.orientation = Eigen::AngleAxisd(M_PI / 2, Vector3::UnitY());
  body.enabled = false;
  scene.colliders = {body};
  if (lies) {
    scene.colliders.push_back({"floor", Plane{}, {}, 0.5, ""});
  } else {
    scene.cloth.pinned = {{0, 0, ""}, {29, 0, ""}, {0, 29, ""}, {29, 29, ""}};
  }
  return scene;
}

const Shape shapes[] = {Cuboid{{0.2, 0.2, 0.3}}, Cylinder{0.3, 0.08}, Sphere{0.15},
                        Capsule{0.3, 0.06}};

struct Exit {
  double fastest = 0;            // [m/s]
  std::optional<double> out_at;  // [s]
};

/// Turns the collider on after 0.3 s, for 0.45 s.
Exit put_on(const Scene& scene) {
  Simulator simulator(scene);
  run(simulator, 0.3);
  simulator.enable_collider(0, true);
  Exit exit;
  for (int frame = 0; frame < 40; ++frame) {
    simulator.step();
    exit.fastest = std::max(exit.fastest, longest_row(simulator.state().velocities));
    const bool is_out = deepest_penetration(simulator) == 0;
    if (is_out && !exit.out_at) exit.out_at = (frame + 1) / 90.0;
    if (!is_out) exit.out_at.reset();
  }
  return exit;
}

class PutOnMaterials : public ::testing::TestWithParam<std::pair<double, double>> {
};  // ks, density

TEST_P(PutOnMaterials, AHangingClothLeavesInOnePiece) {
  const auto [ks, density] = GetParam();
  // By the nearest surfaces points moved at up to 82 m/s.
  for (const Shape& shape : shapes) {
    const Exit exit = put_on(with(shape, ks, density, false));
    EXPECT_LT(exit.fastest, 4) << shape.index();
    EXPECT_LT(exit.out_at.value_or(infinity), 0.35) << shape.index();
  }
}

TEST_P(PutOnMaterials, AHangingClothLeavesAnUprightPost) {
  const auto [ks, density] = GetParam();
  const Exit exit = put_on(with(Capsule{0.3, 0.06}, ks, density, false, true));
  EXPECT_LT(exit.fastest, 30);
  EXPECT_TRUE(exit.out_at);
}

TEST_P(PutOnMaterials, AClothOnAFloorLeavesAwayFromIt) {
  const auto [ks, density] = GetParam();
  // The cloth stayed between both, or was thrown at 23 to 73 m/s.
  for (const Shape& shape : shapes) {
    const Exit exit = put_on(with(shape, ks, density, true));
    EXPECT_LT(exit.fastest, std::holds_alternative<Sphere>(shape) ? 6 : 4) << shape.index();
    EXPECT_LT(exit.out_at.value_or(infinity), 0.35) << shape.index();
  }
}

TEST_P(PutOnMaterials, AHangingClothLeavesAPlateThatPiercesIt) {
  const auto [ks, density] = GetParam();
  Scene scene = with(Cuboid{{0.4, 0.3, 0.01}}, ks, density, false, true);
  for (const double tilt : {0.5, 0.9, 1.5}) {
    scene.colliders[0].pose.orientation = Eigen::AngleAxisd(tilt, Vector3::UnitX());
    const Exit exit = put_on(scene);
    EXPECT_LT(exit.fastest, 30) << tilt;
    EXPECT_LT(exit.out_at.value_or(infinity), 0.1) << tilt;
  }
}

TEST_P(PutOnMaterials, AClothOnAFloorLeavesARodInThatFloor) {
  const auto [ks, density] = GetParam();
  Scene scene = with(Capsule{0.4, 0.02}, ks, density, true);
  scene.colliders[0].pose.position.z() = 0.01;
  const Exit exit = put_on(scene);
  EXPECT_LT(exit.fastest, 6);
  EXPECT_LT(exit.out_at.value_or(infinity), 0.35);
}

TEST(PutOn, JawsThatOverlapByLessThanTheClothHoldIt) {
  Scene scene = with(Cuboid{{0.2, 0.2, 0.1}}, 1000, 0.2, false, true);
  ColliderSpec& lower = scene.colliders[0];
  lower.pose.position.z() = scene.cloth.origin.z() - 0.049;
  lower.enabled = true;
  ColliderSpec upper = lower;
  upper.name = "upper";
  upper.pose.position.z() += 0.098;
  scene.colliders.push_back(upper);
  Simulator simulator(scene);
  run(simulator, 0.2);
  const int middle = 15 * 30 + 15;
  EXPECT_NEAR(simulator.state().positions(middle, 2), scene.cloth.origin.z(), 1e-4);
}

TEST(PutOn, AClothComesUpThroughAFloorThatIsPutAboveIt) {
  Scene scene = with(Sphere{0.1}, 1000, 0.2, true);
  scene.colliders[0].pose.position.z() = 2;
  Simulator simulator(scene);
  run(simulator, 0.3);
  simulator.place_collider(1, {Vector3(0, 0, 0.03)});
  run(simulator, 0.7);
  EXPECT_EQ(deepest_penetration(simulator), 0);
  EXPECT_GT(simulator.state().positions.col(2).minCoeff(), 0.03);
}

TEST(PutOn, AClothThatStartsBetweenABoxAndAFloorLeavesTheBox) {
  Scene scene = with(Cuboid{{0.2, 0.2, 0.3}}, 1000, 0.2, true);
  scene.colliders[0].enabled = true;
  Simulator simulator(scene);
  run(simulator, 1);
  EXPECT_EQ(deepest_penetration(simulator), 0);
}

TEST_P(PutOnMaterials, GoesOnToTheSameBitsFromAStateOnTheWayOut) {
  const auto [ks, density] = GetParam();
  const Scene scene = with(Cuboid{{0.2, 0.2, 0.3}}, ks, density, true);
  Simulator first(scene);
  run(first, 0.3);
  first.enable_collider(0, true);
  run(first, 0.1);
  ASSERT_GT(deepest_penetration(first), 0.01);
  Simulator second(scene);
  second.enable_collider(0, true);
  second.set_state(first.state(), first.memory());
  for (Simulator* simulator : {&first, &second}) run(*simulator, 0.3);
  EXPECT_EQ(first.state().positions, second.state().positions);
  EXPECT_EQ(first.state().velocities, second.state().velocities);
}

TEST(PutOn, ARestoredRunRepeatsTheExitAfterAJump) {
  Scene scene = with(Cuboid{{0.2, 0.2, 0.3}}, 1000, 0.2, false);
  scene.colliders[0].enabled = true;
  const Pose in_cloth = scene.colliders[0].pose;
  scene.colliders[0].pose.position.z() = 0.9;
  Simulator simulator(scene);
  run(simulator, 0.3);
  const auto above = simulator.save();
  simulator.place_collider(0, in_cloth);
  const auto placed = simulator.save();
  run(simulator, 0.2);
  const Points expected = simulator.state().positions;

  simulator.restore(*placed);
  run(simulator, 0.2);
  EXPECT_EQ(simulator.state().positions, expected) << "saved after the jump";
  simulator.restore(*above);
  simulator.place_collider(0, in_cloth);
  run(simulator, 0.2);
  EXPECT_EQ(simulator.state().positions, expected) << "restored before the jump";
}

TEST(PutOn, AThinColliderThatIsPlacedInSmallStepsDoesNotPassThrough) {
  Scene scene = with(Cuboid{{0.2, 0.2, 0.03}}, 1000, 0.2, false, true);
  scene.colliders[0].enabled = true;
  Pose& pose = scene.colliders[0].pose;
  pose.position.z() = 0.7;
  Simulator simulator(scene);
  run(simulator, 0.3);
  for (int frame = 0; frame < 270; ++frame) {
    pose.position.z() -= 0.1 / 90;  // 0.1 m/s
    simulator.place_collider(0, pose);
    simulator.step();
    ASSERT_LT(deepest_penetration(simulator), 0.01) << frame;
  }
  const int middle = 15 * 30 + 15;
  EXPECT_LT(simulator.state().positions(middle, 2), pose.position.z());
}

TEST(PutOn, AJawThatClosesOnClothOnItsWayOutHoldsIt) {
  Scene scene = with(Cuboid{{0.2, 0.2, 0.1}}, 1000, 0.2, false, true);
  const double height = 0.5;
  scene.simulation.gravity = Vector3::Zero();
  scene.cloth.origin.z() = height;
  scene.colliders[0].pose.position.z() = height - 0.049;  // 1 mm of it above the cloth
  ColliderSpec upper = scene.colliders[0];
  upper.name = "upper";
  upper.enabled = true;
  upper.pose.position.z() = height + 0.07;
  scene.colliders.push_back(upper);
  Simulator simulator(scene);
  run(simulator, 0.1);
  simulator.enable_collider(0, true);
  Pose pose = upper.pose;
  for (int frame = 0; frame < 45; ++frame) {  // 0.1 m/s, until it overlaps by 1 mm
    pose.position.z() = std::max(height + 0.05, pose.position.z() - 0.1 / 90);
    simulator.move_collider(1, pose);
    simulator.step();
  }
  const int middle = 15 * 30 + 15;
  EXPECT_NEAR(simulator.state().positions(middle, 2), height, 2e-3);
}

TEST(PutOn, AStateWithAnImpossibleExitIsRefused) {
  Scene scene = with(Cuboid{{0.2, 0.2, 0.3}}, 1000, 0.2, false);
  Simulator simulator(scene);
  run(simulator, 0.3);
  simulator.enable_collider(0, true);
  run(simulator, 0.1);
  std::vector<double> memory = simulator.memory();
  const auto speed = [](const double* v) { return Vector3(v[0], v[1], v[2]).norm(); };
  int found = 0;
  for (std::size_t i = 1; i + 3 < memory.size(); ++i) {
    // That points leave together, and their velocity along z.
    if (memory[i - 1] != 1 || std::abs(memory[i]) > 1e-3 || std::abs(memory[i + 1]) > 1e-3)
      continue;
    if (!(speed(&memory[i]) > 0.1 && speed(&memory[i]) < 2)) continue;
    memory[i] = 1e9;
    ++found;
  }
  ASSERT_EQ(found, 1);
  EXPECT_THROW(simulator.set_state(simulator.state(), memory), InvalidValue);
}

INSTANTIATE_TEST_SUITE_P(Cloths, PutOnMaterials,
                         ::testing::Values(std::pair(1000.0, 0.2), std::pair(20000.0, 1.0)));

}  // namespace
}  // namespace clothsim::put_on_test
