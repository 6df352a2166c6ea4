#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "render_fixture.h"

namespace clothsim::pixels_test {
namespace {

constexpr double depth_tolerance = 1e-4;  // [m]
constexpr float nothing = std::numeric_limits<float>::infinity();

Camera small_camera() { return camera_with_fov(96, 72, 1); }

Color red{1, 0, 0}, blue{0, 0, 1};

/// Without light or shadow: a collider or cloth of one colour.
Cartoon flat_color(const Color& color) {
  Cartoon cartoon;
  cartoon.color = color;
  cartoon.kd = 0;
  cartoon.ambient = 1;
  return cartoon;
}

TEST(Pixels, ATriangleIsInsideAndNotOutside) {
  Points positions(3, 3);
  positions << -0.5, -0.5, 2, 0.5, -0.5, 2, 0, 0.5, 2;
  Snapshot snapshot = triangle_cloth(positions, {{0, 1, 2}});
  snapshot.cloth_shading = flat_color(red);
  snapshot.background.color = blue;
  Camera camera = camera_with_fov(65, 49, M_PI / 2);  // looks along +z of the world, y down

  const Images images = draw(snapshot, camera);
  const auto expect_pixel = [&](int u, int v, int r, int b, float depth, int id) {
    EXPECT_EQ(channel(images, u, v, 0), r) << u << " " << v;
    EXPECT_EQ(channel(images, u, v, 1), 0) << u << " " << v;
    EXPECT_EQ(channel(images, u, v, 2), b) << u << " " << v;
    const auto pixel = static_cast<std::size_t>(v * images.width + u);
    EXPECT_FLOAT_EQ(images.depth[pixel], depth) << u << " " << v;
    EXPECT_EQ(images.mask[pixel], id) << u << " " << v;
  };
  expect_pixel(32, 24, 255, 0, 2, 1);  // its middle
  expect_pixel(25, 17, 255, 0, 2, 1);  // near its upper left corner, at (24, 16)
  expect_pixel(39, 17, 255, 0, 2, 1);
  expect_pixel(32, 30, 255, 0, 2, 1);  // near its tip, at (32, 32)
  expect_pixel(32, 34, 0, 255, nothing, 0);
  expect_pixel(22, 17, 0, 255, nothing, 0);
  expect_pixel(25, 30, 0, 255, nothing, 0);
  expect_pixel(0, 0, 0, 255, nothing, 0);
  expect_pixel(64, 48, 0, 255, nothing, 0);
}

/// Two cloths of a triangle each, the first on the left, and a sphere out of the picture.
Snapshot two_cloths() {
  Points positions(6, 3);
  positions << -0.9, -0.5, 2, -0.1, -0.5, 2, -0.5, 0.5, 2,  //
      0.1, -0.5, 2, 0.9, -0.5, 2, 0.5, 0.5, 2;
  Snapshot snapshot = triangle_cloth(positions, {{0, 1, 2}, {3, 4, 5}});
  Cloth cloth = *snapshot.cloth;
  cloth.first_points = {0, 3};
  cloth.first_triangles = {0, 1};
  cloth.springs = {{SpringFamily::structural, 0, 1, 2, 1, 1},
                   {SpringFamily::structural, 3, 1, 2, 1, 1}};
  snapshot.cloth = std::make_shared<const Cloth>(cloth);
  snapshot.colliders.resize(1);
  snapshot.colliders[0].pose.position = {0, 0, -5};
  snapshot.background.color = {0, 1, 0};
  return snapshot;
}

TEST(Pixels, EachOfSeveralClothsHasItsOwnLook) {
  Snapshot snapshot = two_cloths();
  snapshot.cloth_shading = flat_color({1, 1, 1});
  const Camera camera = camera_with_fov(65, 49, M_PI / 2);
  const auto colors = [&] {  // of both middles, red and blue
    const Images images = draw(snapshot, camera);
    EXPECT_EQ(images.mask[static_cast<std::size_t>(22 * images.width + 24)], 1);
    EXPECT_EQ(images.mask[static_cast<std::size_t>(22 * images.width + 40)], 3);
    return std::array<int, 4>{channel(images, 24, 22, 0), channel(images, 24, 22, 2),
                              channel(images, 40, 22, 0), channel(images, 40, 22, 2)};
  };
  EXPECT_EQ(colors(), (std::array{255, 255, 255, 255}));
  snapshot.cloth_shadings = {flat_color(red), flat_color(blue)};
  EXPECT_EQ(colors(), (std::array{255, 0, 0, 255}));
  snapshot.cloth_shadings = {Wireframe{}, flat_color(blue)};  // the background is between lines
  EXPECT_EQ(colors(), (std::array{0, 0, 0, 255}));
  snapshot.cloth_shadings = {flat_color(red), Wireframe{}};
  EXPECT_EQ(colors(), (std::array{255, 0, 0, 0}));
  Translucent glass;
  glass.image = std::make_shared<const Image>(Image{1, 1, {255, 255, 255}});
  glass.alpha = 1;
  glass.phong.ka = 1;
  glass.phong.diffuse = glass.phong.specular = false;
  snapshot.cloth_shadings = {flat_color(red), glass};
  EXPECT_EQ(colors(), (std::array{255, 0, 255, 255}));
  snapshot.cloth_shadings = {glass, flat_color(blue)};
  EXPECT_EQ(colors(), (std::array{255, 255, 0, 255}));
  snapshot.cloth_shadings = {glass, glass};
  EXPECT_EQ(colors(), (std::array{255, 255, 255, 255}));
}

TEST(Pixels, OfSeveralClothsThoseOfLinesCastNoShadow) {
  // A wall behind both, and a light at the camera, a little aside of it.
  Snapshot snapshot = two_cloths();
  Diffuse white;
  white.color = {1, 1, 1};
  snapshot.colliders[0].shape = Cuboid{{6, 6, 0.2}};
  snapshot.colliders[0].pose.position = {0, 0, 4};
  snapshot.colliders[0].shading = white;
  snapshot.light = {{0, -1, 0}, 10, 0, true};
  snapshot.cloth_shadings = {Wireframe{}, flat_color(blue)};
  const Images images = draw(snapshot, camera_with_fov(65, 49, M_PI / 2));
  int dark[2] = {0, 0};  // pixels of the wall, left and right
  for (int v = 0; v < images.height; ++v) {
    for (int u = 0; u < images.width; ++u) {
      const bool is_wall = images.mask[static_cast<std::size_t>(v * images.width + u)] == 2;
      if (is_wall && channel(images, u, v, 0) < 20) ++dark[u < 32 ? 0 : 1];
    }
  }
  EXPECT_EQ(dark[0], 0);
  EXPECT_GT(dark[1], 20);
}

TEST(Pixels, LinesOfSeveralClothsAreTheirOwn) {
  Snapshot snapshot = two_cloths();
  Wireframe lines;
  lines.colors[0] = red;
  snapshot.cloth_shadings = {lines, flat_color(blue)};
  const Images images = draw(snapshot, camera_with_fov(65, 49, M_PI / 2));
  int left = 0, right = 0;  // red pixels
  for (int v = 0; v < images.height; ++v) {
    for (int u = 0; u < images.width; ++u) {
      if (channel(images, u, v, 0) > 100) ++(u < 32 ? left : right);
    }
  }
  EXPECT_GT(left, 20);
  EXPECT_EQ(right, 0);
}

TEST(Pixels, SphereDepthAndMaskAreExact) {
  Snapshot snapshot;
  ColliderView sphere;
  sphere.shape = Sphere{0.3};
  sphere.pose.position = {0.1, -0.2, 0.4};
  sphere.segments = 12;  // a coarse mesh does not show in depth and mask
  snapshot.colliders = {sphere};
  Camera camera = small_camera();
  camera.pose = look_at({1, -1.5, 1.1}, {0, -0.1, 0.4});
  const Images images = draw(snapshot, camera);

  int inside = 0;
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      // |t d - c|^2 = r^2
      const Vector3 d = pixel_ray(camera, u, v);
      const Vector3 c = sphere.pose.position - camera.pose.position;
      const double a = d.squaredNorm(), b = d.dot(c),
                   discriminant = b * b - a * (c.squaredNorm() - 0.09);
      const auto pixel = static_cast<std::size_t>(v * camera.width + u);
      if (std::abs(discriminant) < 1e-6) continue;  // the ray grazes
      EXPECT_EQ(images.mask[pixel], discriminant > 0 ? 2 : 0) << u << " " << v;
      if (discriminant < 0) {
        EXPECT_EQ(images.depth[pixel], nothing);
      } else {
        EXPECT_NEAR(images.depth[pixel], (b - std::sqrt(discriminant)) / a, depth_tolerance);
        ++inside;
      }
    }
  EXPECT_GT(inside, 500);
}

TEST(Pixels, FromWithinASphereItsInsideIsSeen) {
  Snapshot snapshot;
  ColliderView sphere;
  sphere.shape = Sphere{0.5};
  snapshot.colliders = {sphere};
  const Camera camera = small_camera();
  const Images images = draw(snapshot, camera);
  const Vector3 corner = pixel_ray(camera, 0, 0);
  EXPECT_NEAR(images.depth[0], 0.5 / corner.norm(), depth_tolerance);
  EXPECT_EQ(images.mask[0], 2);
}

TEST(Pixels, PlaneDepthIsExactUpToTheEdgeOfTheSquare) {
  Snapshot snapshot;
  ColliderView plane;
  plane.shape = Plane{};
  plane.pose.position = {0.2, 0.1, -0.3};
  plane.pose.orientation = Eigen::AngleAxisd(0.3, Vector3(1, 2, 0.5).normalized());
  plane.extent = 6;
  plane.segments = 3;
  snapshot.colliders = {plane};
  Camera camera = small_camera();
  camera.pose = look_at({0, -2, 0.6}, {0.2, 0.5, -0.2});
  const Images images = draw(snapshot, camera);

  int on_plane = 0;
  const Vector3 normal = plane.pose.orientation * Vector3::UnitZ();
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const Vector3 d = pixel_ray(camera, u, v);
      const double t = normal.dot(plane.pose.position - camera.pose.position) / normal.dot(d);
      const Vector3 local =
          plane.pose.orientation.inverse() * (camera.pose.position + t * d - plane.pose.position);
      const double edge = 3 - std::max(std::abs(local.x()), std::abs(local.y()));
      if (std::abs(edge) < 0.05 || std::abs(t - camera.near) < 0.01) continue;
      const auto pixel = static_cast<std::size_t>(v * camera.width + u);
      const bool hit = t > camera.near && edge > 0;
      EXPECT_EQ(images.mask[pixel], hit ? 2 : 0) << u << " " << v;
      if (!hit) continue;
      EXPECT_NEAR(images.depth[pixel], t, depth_tolerance) << u << " " << v;
      ++on_plane;
    }
  EXPECT_GT(on_plane, 2000);
}

TEST(Pixels, TiltedClothDepthIsExact) {
  Snapshot snapshot = flat_cloth(20, 20);
  const Eigen::AngleAxisd tilt(0.7, Vector3(1, -0.4, 0.2).normalized());
  const Vector3 corner(-0.5, 1.2, 0.8);
  Points positions = *snapshot.positions * tilt.toRotationMatrix().transpose();
  positions.rowwise() += corner.transpose();
  move_cloth(snapshot, positions);
  Camera camera = small_camera();
  camera.fx *= 1.2;
  camera.cx += 3.3;
  camera.pose = look_at({0, -0.3, 1.4}, {0, 1.5, 1.1});
  const Images images = draw(snapshot, camera);

  int on_cloth = 0;
  const Vector3 normal = tilt * Vector3::UnitZ();
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const Vector3 d = pixel_ray(camera, u, v);
      const double t = normal.dot(corner - camera.pose.position) / normal.dot(d);
      const Vector3 local = tilt.inverse() * (camera.pose.position + t * d - corner);
      const double edge = std::min({local.x(), local.y(), 1 - local.x(), 1 - local.y()});
      if (std::abs(edge) < 1e-4) continue;
      const auto pixel = static_cast<std::size_t>(v * camera.width + u);
      EXPECT_EQ(images.mask[pixel], edge > 0 ? 1 : 0) << u << " " << v;
      if (edge < 0) continue;
      EXPECT_NEAR(images.depth[pixel], t, depth_tolerance) << u << " " << v;
      ++on_cloth;
    }
  EXPECT_GT(on_cloth, 500);
}

TEST(Pixels, FarFromTheOriginNothingGetsCoarser) {
  // A kilometre from the origin, as in a map frame. Floats there are 6e-5 m apart.
  const Vector3 away(-1000, 2000, 50);
  Snapshot snapshot = flat_cloth(5, 5);
  Camera camera = small_camera();
  camera.pose = look_at({0.4, -0.5, 0.9}, {0.5, 0.5, 0});
  snapshot.colliders.resize(1);
  snapshot.colliders[0].pose.position = {0.5, 0.6, 0.1};
  const Images near = draw(snapshot, camera);

  move_cloth(snapshot, snapshot.positions->rowwise() + away.transpose());
  snapshot.colliders[0].pose.position += away;
  snapshot.light.position += away;
  camera.pose.position += away;
  const Images far = draw(snapshot, camera);
  EXPECT_EQ(near.mask, far.mask);
  for (std::size_t i = 0; i < near.depth.size(); ++i)
    if (std::isfinite(near.depth[i])) {
      EXPECT_NEAR(near.depth[i], far.depth[i], 2e-6);
    }
}

TEST(Pixels, AllThreeImagesShowTheSameMomentOfAMovingCloth) {
  Snapshot snapshot = flat_cloth(10, 10);
  snapshot.cloth_shading = flat_color(red);
  snapshot.background.color = blue;
  Camera camera = small_camera();
  camera.pose = look_at({0.5, 0.5, 3}, {0.5, 0.5, 0});
  const Points start = *snapshot.positions;
  for (int frame = 0; frame < 10; ++frame) {
    const double height = 0.1 * frame;
    move_cloth(snapshot, start.rowwise() + Vector3(0.05 * frame, 0, height).transpose());
    const Images images = draw(snapshot, camera);
    int seen = 0;
    for (int v = 1; v < camera.height - 1; ++v)
      for (int u = 1; u < camera.width - 1; ++u) {
        const auto pixel = static_cast<std::size_t>(v * camera.width + u);
        EXPECT_EQ(std::isfinite(images.depth[pixel]), images.mask[pixel] == 1);
        if (images.mask[pixel] == 1) {
          EXPECT_NEAR(images.depth[pixel], 3 - height, depth_tolerance);
          ++seen;
        }
        if (surrounded_by(images, u, v, 1)) {
          EXPECT_EQ(channel(images, u, v, 0), 255);
        }
        if (surrounded_by(images, u, v, 0)) {
          EXPECT_EQ(channel(images, u, v, 2), 255);
        }
      }
    EXPECT_GT(seen, 100);
  }
}

TEST(Pixels, NearerObjectsHideFartherOnes) {
  Snapshot snapshot = flat_cloth(10, 10);
  snapshot.colliders.resize(2);
  snapshot.colliders[0].pose.position = {0.5, 0.5, 1};     // above the cloth
  snapshot.colliders[1].pose.position = {0.5, 0.5, -0.5};  // below it
  Camera camera = small_camera();
  camera.pose = look_at({0.5, 0.5, 3}, {0.5, 0.5, 0});
  const Images above = draw(snapshot, camera);
  const auto middle = static_cast<std::size_t>(36 * camera.width + 48);
  EXPECT_EQ(above.mask[middle], 2);
  EXPECT_NEAR(above.depth[middle], 1.8, 1e-3);
  camera.pose = look_at({0.5, 0.5, -3}, {0.5, 0.5, 0});
  EXPECT_EQ(draw(snapshot, camera).mask[middle], 3);
}

TEST(Pixels, ClothThatLiesOnASphereHidesIt) {
  // A cap of the sphere with its points 1e-4 m outside: between them the flat triangles dip
  // below the surface, and yet the cloth is visible.
  const double radius = 0.2, offset = 1e-4;
  Snapshot snapshot = flat_cloth(15, 15);
  Points positions = *snapshot.positions;
  for (Eigen::Index i = 0; i < positions.rows(); ++i) {
    const double x = 0.4 * (positions(i, 0) - 0.5), y = 0.4 * (positions(i, 1) - 0.5);
    positions.row(i) = (radius + offset) * Vector3(x, y, 0.2).normalized();
  }
  move_cloth(snapshot, positions);
  snapshot.cloth_shading = flat_color(red);
  ColliderView sphere;
  sphere.shape = Sphere{radius};
  sphere.segments = 128;
  sphere.shading = flat_color(blue);
  snapshot.colliders = {sphere};
  snapshot.background.color = {0, 0, 0};

  for (const Vector3& eye : {Vector3(0, 0, 1), Vector3(0.5, 0.3, 0.6)}) {
    Camera camera = small_camera();
    camera.pose = look_at(eye, {0, 0, 0});
    const Images images = draw(snapshot, camera);
    int cloth_pixels = 0;
    for (int v = 1; v < camera.height - 1; ++v)
      for (int u = 1; u < camera.width - 1; ++u) {
        const Vector3 d = pixel_ray(camera, u, v).normalized();
        const double middle = -d.dot(eye), aside = (eye + middle * d).norm();
        if (aside > radius) continue;
        const Vector3 hit = eye + (middle - std::sqrt(radius * radius - aside * aside)) * d;
        if (std::max(std::abs(hit.x()), std::abs(hit.y())) > 0.85 * hit.z()) continue;
        EXPECT_EQ(images.mask[static_cast<std::size_t>(v * camera.width + u)], 1) << u << " " << v;
        EXPECT_EQ(channel(images, u, v, 2), 0) << u << " " << v;
        ++cloth_pixels;
      }
    EXPECT_GT(cloth_pixels, 200);
  }
}

TEST(Pixels, EdgesOfTheColourImageAreSmoothAndThoseOfTheMaskAreNot) {
  Snapshot snapshot = flat_cloth(2, 2);
  snapshot.cloth_shading = flat_color({1, 1, 1});
  snapshot.background.color = {0, 0, 0};
  Camera camera = small_camera();
  camera.pose = look_at({0.5, -1, 1}, {0.55, 0.5, 0});
  const Images images = draw(snapshot, camera);
  int between = 0;
  for (const std::uint8_t value : images.color) between += value > 20 && value < 235;
  EXPECT_GT(between, 50);
  for (const std::uint8_t id : images.mask) EXPECT_TRUE(id == 0 || id == 1);
}

TEST(Pixels, TheColourImageIsTheSameWithAndWithoutTheOthers) {
  Snapshot snapshot = flat_cloth(3, 3);
  snapshot.cloth_shading = flat_color(red);
  snapshot.background.color = Color{1, 1, 1};
  Camera camera = small_camera();
  camera.pose = look_at({0.3, -1, 1}, {0.5, 0.5, 0});
  const Images all = draw(snapshot, camera);
  Images alone;
  shared_renderer().render(snapshot, camera, {true, false, false}, alone);
  EXPECT_EQ(all.color, alone.color);
}

}  // namespace
}  // namespace clothsim::pixels_test
