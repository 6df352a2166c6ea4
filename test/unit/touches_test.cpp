// Contacts of a cloth with colliders.

#include "clothsim/run/touches.h"

#include "verification/testing.h"

namespace clothsim::touches_test {
namespace {

using namespace test;

ColliderSpec collider(const char* name, const Shape& shape, const Vector3& position) {
  ColliderSpec spec;
  spec.name = name;
  spec.shape = shape;
  spec.pose.position = position;
  spec.friction = 0.5;
  return spec;
}

/// A cloth of 1 m, at 0.5 mm over z = 0, that comes to rest on the colliders.
Scene lying(const std::vector<ColliderSpec>& colliders) {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 11;
  scene.cloth.origin = {0, 0, 5e-4};
  scene.colliders = colliders;
  return scene;
}

TEST(Touches, AClothThatLiesFlatTouchesWithAllOfItsPoints) {
  Simulator simulator(
      lying({collider("ground", Plane{}, {0, 0, 0}), collider("far", Sphere{0.2}, {0.5, 0.5, 3}),
             collider("off", Plane{}, {0, 0, 0.1})}));
  simulator.enable_collider(2, false);
  EXPECT_EQ(find_touches(simulator)[0].count, 0);  // not yet
  run(simulator, 1);
  const std::vector<Touch> touches = find_touches(simulator);
  ASSERT_EQ(touches.size(), 3u);
  EXPECT_EQ(touches[0].count, 121);
  EXPECT_LT((touches[0].middle - Vector3(0.5, 0.5, 0)).norm(), 1e-3);
  for (const int i : {1, 2}) {
    EXPECT_EQ(touches[static_cast<std::size_t>(i)].count, 0);
    EXPECT_EQ(touches[static_cast<std::size_t>(i)].middle, Vector3(0, 0, 0));
  }
}

TEST(Touches, AreWhereTheColliderIs) {
  // The cloth is half a reach above its contact height, and over the box with six columns.
  const double height = 5e-4 - 1.5 * surface_offset;
  Simulator simulator(lying({collider("box", Cuboid{{2, 1, 0.2}}, {0, 0, 5})}));
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(M_PI / 2, Vector3::UnitZ()));
  simulator.place_collider(0, {Vector3(0.05, 0.5, height - 0.1), turned});
  const Touch touch = find_touches(simulator)[0];
  EXPECT_EQ(touch.count, 66);
  EXPECT_LT((touch.middle - Vector3(0.25, 0.5, 5e-4)).norm(), 1e-12);
  simulator.place_collider(0, {Vector3(0.05, 0.5, height - 0.1 - surface_offset), turned});
  EXPECT_EQ(find_touches(simulator)[0].count, 0);
}

TEST(Touches, ARodBetweenPointsTouchesATriangle) {
  const Vector3 place(0.53, 0.52, 5e-4 - 1.5 * surface_offset - 0.004);
  Simulator simulator(lying({collider("rod", Capsule{0.01, 0.004}, {0, 0, 5})}));
  simulator.place_collider(
      0, {place, Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vector3::UnitY()))});
  const Touch touch = find_touches(simulator)[0];
  EXPECT_EQ(touch.count, 1);
  EXPECT_NEAR(touch.middle.x(), place.x(), 0.0051);  // anywhere along it
  EXPECT_NEAR(touch.middle.y(), place.y(), 1e-12);
  EXPECT_NEAR(touch.middle.z(), 5e-4, 1e-12);
}

}  // namespace
}  // namespace clothsim::touches_test
