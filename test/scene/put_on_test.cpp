// Colliders that are turned on where a cloth is: it leaves them in one piece, slowly, and soon.

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

struct Exit {
  double fastest = 0;            // [m/s]
  std::optional<double> out_at;  // [s]
};

/// Turns the collider on after 0.3 s, for 0.7 s.
Exit put_on(const Scene& scene) {
  Simulator simulator(scene);
  run(simulator, 0.3);
  simulator.enable_collider(0, true);
  Exit exit;
  for (int frame = 0; frame < 63; ++frame) {
    simulator.step();
    exit.fastest = std::max(exit.fastest, longest_row(simulator.state().velocities));
    const bool is_out = deepest_penetration(simulator) == 0;
    if (is_out && !exit.out_at) exit.out_at = (frame + 1) / 90.0;
    if (!is_out) exit.out_at.reset();
  }
  return exit;
}

class PutOn : public ::testing::TestWithParam<std::pair<double, double>> {};  // ks, density

TEST_P(PutOn, AHangingClothLeavesInOnePiece) {
  const auto [ks, density] = GetParam();
  // With each point by its nearest surface up to 82 m/s.
  for (const Shape& shape : {Shape(Cuboid{{0.2, 0.2, 0.3}}), Shape(Cylinder{0.3, 0.08})}) {
    const Exit exit = put_on(with(shape, ks, density, false));
    EXPECT_LT(exit.fastest, 4) << shape.index();
    EXPECT_TRUE(exit.out_at) << shape.index();
  }
}

TEST_P(PutOn, AHangingClothLeavesAPostAlongIt) {
  const auto [ks, density] = GetParam();
  const Exit exit = put_on(with(Capsule{0.3, 0.06}, ks, density, false, true));
  EXPECT_LT(exit.fastest, 30);
  EXPECT_TRUE(exit.out_at);
}

TEST_P(PutOn, AClothOnAFloorLeavesAwayFromIt) {
  const auto [ks, density] = GetParam();
  // Between both it stayed, or it was thrown at 23 to 73 m/s.
  for (const Shape& shape : {Shape(Cuboid{{0.2, 0.2, 0.3}}), Shape(Sphere{0.15})}) {
    const Exit exit = put_on(with(shape, ks, density, true));
    EXPECT_LT(exit.fastest, std::holds_alternative<Sphere>(shape) ? 30 : 6) << shape.index();
    EXPECT_TRUE(exit.out_at) << shape.index();
  }
}

TEST(PutUpon, AClothComesUpThroughAFloorThatIsPutAboveIt) {
  Scene scene = with(Sphere{0.1}, 1000, 0.2, true);
  scene.colliders[0].pose.position.z() = 2;
  Simulator simulator(scene);
  run(simulator, 0.3);
  simulator.place_collider(1, {Vector3(0, 0, 0.03)});
  run(simulator, 0.7);
  EXPECT_EQ(deepest_penetration(simulator), 0);
  EXPECT_GT(simulator.state().positions.col(2).minCoeff(), 0.03);
}

TEST(PutUpon, AClothThatStartsBetweenABoxAndAFloorLeavesTheBox) {
  Scene scene = with(Cuboid{{0.2, 0.2, 0.3}}, 1000, 0.2, true);
  scene.colliders[0].enabled = true;
  Simulator simulator(scene);
  run(simulator, 1);
  EXPECT_EQ(deepest_penetration(simulator), 0);
}

TEST_P(PutOn, GoesOnToTheSameBitsFromAStateOnTheWayOut) {
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

INSTANTIATE_TEST_SUITE_P(Materials, PutOn,
                         ::testing::Values(std::pair(1000.0, 0.2), std::pair(20000.0, 1.0)));

}  // namespace
}  // namespace clothsim::put_on_test
