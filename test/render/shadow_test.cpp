// Shadows where something lies between the surface and the light, and nowhere else.

#include <gtest/gtest.h>

#include <cmath>

#include "stage.h"

namespace clothsim::shadow_test {
namespace {

/// White without ambient light: black in the shadow.
Diffuse white() {
  Diffuse diffuse;
  diffuse.color = {1, 1, 1};
  return diffuse;
}

/// A ball of 0.3 m above a plane at height 0.
Snapshot ball_on_plane() {
  Snapshot snapshot;
  snapshot.colliders.resize(2);
  snapshot.colliders[0].shape = Plane{};
  snapshot.colliders[0].shading = white();
  snapshot.colliders[1].shape = Sphere{0.3};
  snapshot.colliders[1].segments = 200;
  snapshot.colliders[1].shading = white();
  snapshot.colliders[1].pose.position = {0.2, 0.1, 0.8};
  snapshot.light = {{1, -0.3, 2.5}, 15, 1, true};
  return snapshot;
}

Camera camera_above(int width = 320) {
  Camera camera = camera_with_fov(width, width * 3 / 4, 0.9);
  camera.pose = look_at({-1.5, -2, 3}, {-0.2, 0.2, 0});
  return camera;
}

/// Whether the segment from a point to the light meets the sphere.
bool sphere_hides(const Vector3& point, const Vector3& light, const Vector3& center,
                  double radius) {
  const Vector3 way = light - point;
  const double t = std::min(1.0, std::max(0.0, (center - point).dot(way) / way.squaredNorm()));
  return (point + t * way - center).norm() < radius;
}

/// Centre of a set of pixels, and radius of a disk of the same area.
struct Spot {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double count = 0;

  void add(int u, int v) { center += (Eigen::Vector2d(u, v) - center) / ++count; }
  double radius() const { return std::sqrt(count / M_PI); }
};

/// The picture with and without shadows.
std::pair<Images, Images> with_and_without(Snapshot snapshot, const Camera& camera) {
  snapshot.light.shadows = true;
  Images with = draw(snapshot, camera);
  snapshot.light.shadows = false;
  return {std::move(with), draw(snapshot, camera)};
}

// The light at its distance, so far away that its rays are parallel, and nearer to the ball.
class BallsShadow : public ::testing::TestWithParam<double> {};

TEST_P(BallsShadow, IsWhereRaysToTheLightMeetTheBall) {
  Snapshot snapshot = ball_on_plane();
  const Vector3 center = snapshot.colliders[1].pose.position;
  snapshot.light.position = center + GetParam() * (snapshot.light.position - center);
  snapshot.light.intensity *= std::pow(std::max(1.0, GetParam()), 2);
  const Camera camera = camera_above();
  const auto [images, bright] = with_and_without(snapshot, camera);
  Spot drawn, expected;
  int wrong = 0;
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const auto i = static_cast<std::size_t>(v * camera.width + u);
      if (images.mask[i] != 2) continue;
      const Vector3 at = camera.pose.position + double(images.depth[i]) * pixel_ray(camera, u, v);
      const auto hides = [&](double radius) {
        return sphere_hides(at, snapshot.light.position, center, radius);
      };
      const bool dark = 2 * channel(images, u, v, 0) < channel(bright, u, v, 0);
      if (dark) drawn.add(u, v);
      if (hides(0.3)) expected.add(u, v);
      // Some 2 pixels of the picture, and of the map, to either side of the shadow's edge.
      if (hides(0.29) == hides(0.31) && dark != hides(0.3)) ++wrong;
    }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(expected.count, 1000);
  EXPECT_LT((drawn.center - expected.center).norm(), 0.2);  // [pixel]
  EXPECT_NEAR(drawn.radius(), expected.radius(), 0.5);
}

INSTANTIATE_TEST_SUITE_P(Lights, BallsShadow, ::testing::Values(1, 1e4, 0.7));

TEST(Shadow, OfABallUnderTheLightIsACircleOfTheConesRadius) {
  // Straight above it: the cone that touches the ball of radius r at distance d meets the plane at
  // distance D in a circle of radius D tan(asin(r / d)).
  Snapshot snapshot = ball_on_plane();
  snapshot.colliders[1].pose.position = {0, 0, 1};
  snapshot.light = {{0, 0, 3}, 15, 1, true};
  Camera camera = camera_with_fov(400, 400, 0.6);
  camera.pose = look_at({0, 0, 0.6}, {0, 0, 0});  // between the ball and the plane
  camera.fx = camera.fy = 220;
  const Images images = draw(snapshot, camera);
  Spot drawn;
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u)
      if (channel(images, u, v, 0) < 100) drawn.add(u, v);
  EXPECT_LT((drawn.center - Eigen::Vector2d(camera.cx, camera.cy)).norm(), 0.2);
  EXPECT_NEAR(drawn.radius(), camera.fx / 0.6 * 3 * std::tan(std::asin(0.3 / 2)), 0.7);
}

TEST(Shadow, OfAClothOnItselfIsWhereRaysToTheLightMeetIt) {
  // Folded over: a part of the lower layer is in the shadow of the upper one, above which the light
  // stands to the side.
  Snapshot snapshot = flat_cloth(40, 40);
  Points folded = *snapshot.positions;
  for (Eigen::Index i = 0; i < folded.rows(); ++i) {
    const double y = folded(i, 1);
    if (y > 0.7) {
      folded(i, 1) = 1.4 - y;
      folded(i, 2) = 0.15;
    } else if (y > 0.65) {
      folded(i, 2) = 0.15 * (y - 0.65) / 0.05;
    }
  }
  move_cloth(snapshot, folded);
  snapshot.cloth_shading = white();
  snapshot.light = {{0.5, 0.9, 1.2}, 3, 1, true};
  Camera camera = camera_with_fov(320, 240, 0.8);
  camera.pose = look_at({0.5, -1.2, 1.1}, {0.5, 0.4, 0});
  const auto [images, bright] = with_and_without(snapshot, camera);
  const Mesh mesh = cloth_mesh(snapshot);

  int dark = 0, lit = 0;
  for (int v = 1; v < camera.height - 1; v += 4)
    for (int u = 1; u < camera.width - 1; u += 3) {
      if (!surrounded_by(images, u, v, 1)) continue;
      const auto i = static_cast<std::size_t>(v * camera.width + u);
      const Vector3 ray = pixel_ray(camera, u, v);
      const Vector3 at = camera.pose.position + (double(images.depth[i]) - 1e-4) * ray;
      // The same at some pixels around: not on an edge of the shadow.
      int free = 0;
      for (int k = 0; k < 9; ++k) {
        const Vector3 near = at + 0.012 * Vector3(k % 3 - 1, k / 3 - 1, 0);
        free += !trace(mesh, near, snapshot.light.position - near);
      }
      if (free != 0 && free != 9) continue;
      const int without = channel(bright, u, v, 0);
      if (without < 20) continue;  // turned away from the light
      EXPECT_NEAR(channel(images, u, v, 0), free == 9 ? without : 0, 1) << u << " " << v;
      ++(free == 9 ? lit : dark);
    }
  EXPECT_GT(lit, 400);
  EXPECT_GT(dark, 60);
}

TEST(Shadow, NothingShadesItself) {
  // A waved cloth, and a ball of many faces, seen and lit from the side: no ray to the light meets
  // its own surface where it is lit, except at the waves' crests and the ball's terminator.
  Stage stage;
  stage.snapshot.colliders.clear();
  stage.snapshot.cloth_shading = white();
  stage.snapshot.light = {{0.5, 0.5, 3}, 9, 1, true};
  const auto [cloth, bright_cloth] = with_and_without(stage.snapshot, stage.camera);
  EXPECT_EQ(cloth.color, bright_cloth.color);

  Snapshot ball = ball_on_plane();
  ball.colliders.erase(ball.colliders.begin());
  ball.colliders[0].segments = 64;
  Camera camera = camera_with_fov(200, 150, 0.3);
  camera.pose = look_at({2, -1, 2}, {0.2, 0.1, 0.8});
  const auto [shaded, bright] = with_and_without(ball, camera);
  for (std::size_t i = 0; i < shaded.color.size(); ++i)
    if (bright.color[i] > 60) {
      EXPECT_NEAR(shaded.color[i], bright.color[i], 1) << i;
    }
}

TEST(Shadow, StaysWhereItIsFarFromTheOrigin) {
  Snapshot snapshot = ball_on_plane();
  Camera camera = camera_above();
  const Images near = draw(snapshot, camera);
  const Vector3 away(-1000, 2000, 50);
  for (ColliderView& collider : snapshot.colliders) collider.pose.position += away;
  snapshot.light.position += away;
  camera.pose.position += away;
  const Images far = draw(snapshot, camera);
  int different = 0;
  for (std::size_t i = 0; i < near.color.size(); ++i)
    different += std::abs(near.color[i] - far.color[i]) > 4;
  EXPECT_LT(different, 100);  // on the edges, of 230,400
}

TEST(Shadow, IsOfNoConsequenceWhereNothingCastsOne) {
  Snapshot plane = ball_on_plane();
  plane.colliders[1].visible = false;
  const Camera camera = camera_above(80);
  auto pictures = with_and_without(plane, camera);
  EXPECT_EQ(pictures.first.color, pictures.second.color);
  plane.colliders[1].visible = true;
  plane.colliders[1].shading = Wireframe{};
  pictures = with_and_without(plane, camera);
  EXPECT_EQ(pictures.first.color, pictures.second.color);
  plane = ball_on_plane();  // the light in the ball's middle
  plane.light.position = plane.colliders[1].pose.position;
  pictures = with_and_without(plane, camera);
  EXPECT_EQ(pictures.first.color, pictures.second.color);
  plane.colliders.clear();
  pictures = with_and_without(plane, camera);
  EXPECT_EQ(pictures.first.color, pictures.second.color);
}

TEST(Shadow, OfALightAmongThingsIsWithin75DegreesOfTheirMiddle) {
  // The light is above a plane, between a ball that it lights and the cloth.
  Snapshot snapshot = ball_on_plane();
  snapshot.colliders[1].pose.position = {0, 0, 0.5};
  snapshot.colliders.push_back(snapshot.colliders[1]);
  snapshot.colliders[2].pose.position = {0, 0, 2.6};
  snapshot.light.position = {0.1, 0.1, 1.8};  // the middle of all is at 1.55
  Camera camera = camera_with_fov(100, 100, 0.3);
  camera.pose = look_at({0.02, 0.02, 0.15}, {0, 0, 0});  // under the ball
  const Images images = draw(snapshot, camera);
  for (const std::uint8_t value : images.color) EXPECT_EQ(value, 0);
}

TEST(Shadow, EachShaderHasOne) {
  const Camera camera = camera_above(160);
  Snapshot snapshot = ball_on_plane();
  PhongTexture textured;
  textured.image = small_image();
  Translucent translucent;
  translucent.image = small_image();
  Bump bump;
  bump.height_map = small_heights();
  Displacement displacement;
  displacement.height_map = small_heights();
  displacement.height_scaling = 1e-3;
  for (const Shading& shading :
       {Shading(white()), Shading(BlinnPhong{}), Shading(textured), Shading(translucent),
        Shading(bump), Shading(displacement), Shading(Cartoon{})}) {
    snapshot.colliders[0].shading = shading;
    const auto [with, without] = with_and_without(snapshot, camera);
    int darker = 0, brighter = 0;
    for (std::size_t i = 0; i < with.color.size(); ++i) {
      darker += with.color[i] + 10 < without.color[i];
      brighter += with.color[i] > without.color[i] + 10;
    }
    EXPECT_GT(darker, 300) << shading_name(shading);
    EXPECT_LT(brighter, 30) << shading_name(shading);
  }
}

}  // namespace
}  // namespace clothsim::shadow_test
