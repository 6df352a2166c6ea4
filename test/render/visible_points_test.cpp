// Points that the camera sees, against a test of every triangle.

#include "clothsim/render/visible_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "moving.h"

namespace clothsim::visible_points_test {
namespace {

std::vector<std::uint32_t> draw_visible(const Snapshot& snapshot, const Camera& camera) {
  WantedImages wanted{false, false, false};
  wanted.visible_points = true;
  Images images;
  shared_renderer().render(snapshot, camera, wanted, images);
  EXPECT_TRUE(images.visible_points.has_value());
  return images.visible_points.value_or(std::vector<std::uint32_t>());
}

/// A mesh without the triangles at a point.
Mesh without_point(Mesh mesh, int point) {
  auto& all = mesh.triangles;
  all.erase(
      std::remove_if(all.begin(), all.end(),
                     [&](const auto& t) { return std::count(t.begin(), t.end(), point) > 0; }),
      all.end());
  return mesh;
}

/// By every triangle, and the sphere's equation.
bool is_visible(const Moving& moving, int i) {
  const Camera& camera = moving.camera_now;
  const Vector3 point = moving.now.positions->row(i), eye = camera.pose.position;
  const Eigen::Vector2d at = project(camera, point);
  if ((at.array() < -0.5).any() || at.x() >= camera.width - 0.5 || at.y() >= camera.height - 0.5)
    return false;
  const double length = (point - eye).norm(), most = length - on_surface;
  const Vector3 ray = (point - eye) / length;
  for (const Mesh& mesh :
       {without_point(cloth_mesh(moving.now), i), collider_mesh(moving.now.colliders[1])}) {
    const auto hit = trace(mesh, eye, ray);
    if (hit && hit->distance < most) return false;
  }
  const Vector3 center = moving.now.colliders[0].pose.position - eye;
  const double middle = center.dot(ray), aside = (center - middle * ray).norm();
  return aside > 0.3 || middle - std::sqrt(0.09 - aside * aside) > most;
}

TEST(VisiblePoints, AreThoseThatEveryTriangleLeavesFree) {
  Moving moving;  // box and ball stand before a part of the cloth
  Points folded = *moving.now.positions;
  for (Eigen::Index i = 0; i < folded.rows(); ++i)  // and it hides some of itself
    if (folded(i, 1) < 0.3) folded.row(i) = Vector3(folded(i, 0), 0.6 - folded(i, 1), 0.15);
  move_cloth(moving.now, folded);
  for (const double zoom : {1.0, 3.0}) {
    moving.camera_now.fx *= zoom;
    moving.camera_now.fy *= zoom;
    std::vector<std::uint32_t> expected;
    for (int i = 0; i < moving.now.cloth->num_points(); ++i)
      if (is_visible(moving, i)) expected.push_back(static_cast<std::uint32_t>(i));
    EXPECT_EQ(draw_visible(moving.now, moving.camera_now), expected);
    EXPECT_GT(expected.size(), 20u);
    EXPECT_LT(expected.size(), 210u);  // of 256
  }
}

TEST(VisiblePoints, WithNothingElseAreAllAndBehindAWallNone) {
  Snapshot snapshot = flat_cloth(7, 9);
  Camera camera = camera_with_fov(80, 60, 1);
  camera.pose = look_at({0.5, 0.5, 3}, {0.5, 0.5, 0});
  EXPECT_EQ(draw_visible(snapshot, camera).size(), 63u);
  camera.near = 3.01;
  EXPECT_TRUE(draw_visible(snapshot, camera).empty());
  camera.near = 0.05;
  camera.far = 2.99;
  EXPECT_TRUE(draw_visible(snapshot, camera).empty());
  camera.far = 100;
  ColliderView wall;
  wall.shape = Plane{};
  wall.pose.position.z() = 1;
  snapshot.colliders = {wall};
  EXPECT_TRUE(draw_visible(snapshot, camera).empty());
  camera.near = 2.01;  // cuts the wall away
  EXPECT_EQ(draw_visible(snapshot, camera).size(), 63u);
  camera.near = 0.05;
  snapshot.colliders[0].visible = false;
  EXPECT_EQ(draw_visible(snapshot, camera).size(), 63u);
  snapshot.colliders[0].visible = true;
  snapshot.colliders[0].pose.position.z() = -0.5 * on_surface;  // the cloth lies on it
  EXPECT_EQ(draw_visible(snapshot, camera).size(), 63u);
  snapshot.colliders[0].pose.position.z() = 0.5 * on_surface;  // as it does a little inside
  EXPECT_EQ(draw_visible(snapshot, camera).size(), 63u);
  camera.pose = look_at({0.5, 0.5, 3}, {0.5, 0.5, 6});  // looks away
  EXPECT_TRUE(draw_visible(snapshot, camera).empty());
}

TEST(VisiblePoints, OfARopeAreNotHiddenByItsTube) {
  Snapshot rope = flat_cloth(30, 1);
  Camera camera = camera_with_fov(80, 60, 1);
  camera.pose = look_at({0.5, -2, 0}, {0.5, 0, 0});
  EXPECT_EQ(draw_visible(rope, camera).size(), 30u);
  rope.colliders.resize(1);
  rope.colliders[0].pose.position = {0.5, -0.5, 0};
  const std::size_t seen = draw_visible(rope, camera).size();
  EXPECT_GT(seen, 5u);
  EXPECT_LT(seen, 25u);
}

}  // namespace
}  // namespace clothsim::visible_points_test
