#include <gtest/gtest.h>

#include <cmath>

#include "clothsim/model/errors.h"
#include "render_fixture.h"

namespace clothsim::camera_test {
namespace {

TEST(Camera, FieldOfViewSpansTheImageFromEdgeToEdge) {
  const Camera camera = camera_with_fov(640, 480, M_PI / 2);
  // The left edge of the image is at u = -0.5, at 45 degrees.
  EXPECT_NEAR((-0.5 - camera.cx) / camera.fx, -1, 1e-12);
  EXPECT_NEAR((639.5 - camera.cx) / camera.fx, 1, 1e-12);
  EXPECT_EQ(camera.cx, 319.5);
  EXPECT_EQ(camera.cy, 239.5);
}

TEST(Camera, LookAtPutsTheTargetInFrontAndWorldUpUp) {
  for (const Vector3& eye : {Vector3(2, -1, 3), Vector3(-4, 0, 0.5), Vector3(0.3, 0.2, 5)}) {
    const Vector3 target(0.3, 0.2, 0.1);
    const Pose pose = look_at(eye, target);
    const Vector3 seen = pose.orientation.inverse() * (target - eye);
    EXPECT_NEAR(seen.x(), 0, 1e-12);
    EXPECT_NEAR(seen.y(), 0, 1e-12);
    EXPECT_NEAR(seen.z(), (target - eye).norm(), 1e-12);
    const Vector3 right = pose.orientation * Vector3::UnitX();
    EXPECT_NEAR(right.z(), 0, 1e-12);
    const Vector3 down = pose.orientation * Vector3::UnitY();
    EXPECT_LE(down.z(), 1e-12);
  }
}

TEST(Camera, LookingStraightDownHasAnUpToo) {
  const Pose pose = look_at({0, 0, 2}, {0, 0, 0});
  const Vector3 down = pose.orientation * Vector3::UnitY();
  EXPECT_NEAR((down - Vector3(0, -1, 0)).norm(), 0, 1e-12);
}

TEST(Camera, BadValuesAreRefusedByName) {
  const auto refused = [](auto change) {
    Camera camera;
    change(camera);
    try {
      validate(camera);
    } catch (const InvalidValue& error) {
      return error.key().front();
    }
    return std::string("nothing");
  };
  EXPECT_EQ(refused([](Camera&) {}), "nothing");
  EXPECT_EQ(refused([](Camera& c) { c.width = 0; }), "width");
  EXPECT_EQ(refused([](Camera& c) { c.height = 100000; }), "height");
  EXPECT_EQ(refused([](Camera& c) { c.fx = -1; }), "fx");
  EXPECT_EQ(refused([](Camera& c) { c.fy = NAN; }), "fy");
  EXPECT_EQ(refused([](Camera& c) { c.cx = INFINITY; }), "cx");
  EXPECT_EQ(refused([](Camera& c) { c.near = 0; }), "near");
  EXPECT_EQ(refused([](Camera& c) { c.far = c.near / 2; }), "far");
  EXPECT_EQ(refused([](Camera& c) { c.pose.position.y() = NAN; }), "position");
  EXPECT_THROW(camera_with_fov(640, 480, 0), InvalidValue);
  EXPECT_THROW(camera_with_fov(640, 480, 4), InvalidValue);
  EXPECT_THROW(look_at({1, 2, 3}, {1, 2, 3}), InvalidValue);
}

}  // namespace
}  // namespace clothsim::camera_test
