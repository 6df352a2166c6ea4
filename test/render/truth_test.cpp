// Images of the surfaces other than depth and mask (pixels_test.cpp), against the ray through each
// pixel's centre.

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "meshes.h"
#include "moving.h"

namespace clothsim::truth_test {
namespace {

WantedImages everything() {
  WantedImages wanted;
  wanted.uv = wanted.normals = wanted.flow = true;
  return wanted;
}

Images draw_all(const Snapshot& snapshot, const Camera& camera) {
  Images images;
  shared_renderer().render(snapshot, camera, everything(), images);
  return images;
}

// ---- uv ----

TEST(Truth, UvIsThatOfTheClothWhereTheRayMeetsIt) {
  Stage stage;  // 0.1 of uv are some 10 pixels
  const Images images = draw_all(stage.snapshot, stage.camera);
  int on_cloth = 0;
  for_each_pixel(stage.camera, [&](int u, int v) {
    const Eigen::Vector2d uv = pixel<2>(images, images.uv, u, v);
    if (id(images, u, v) != 1) {
      EXPECT_TRUE(std::isnan(uv.x()) && std::isnan(uv.y())) << u << " " << v;
      return;
    }
    const auto hit = trace(stage.cloth, stage.camera.pose.position, pixel_ray(stage.camera, u, v));
    if (!hit) return;  // the rim runs through the pixel
    const auto depth = images.depth[static_cast<std::size_t>(v * images.width + u)];
    if (std::abs(hit->distance - double(depth)) > 1e-4) return;  // and so does the rim of a fold
    EXPECT_LT((uv - hit->uv).norm(), 1e-5) << u << " " << v;
    ++on_cloth;
  });
  EXPECT_GT(on_cloth, 2000);
}

TEST(Truth, UvOfAPointIsItsColumnAndRow) {
  Snapshot snapshot = flat_cloth(4, 3);
  Camera camera = camera_with_fov(101, 101, 1);
  camera.pose = look_at({0.5, 0.5, 2}, {0.5, 0.5, 0});
  const Images images = draw_all(snapshot, camera);
  for (int i = 0; i < 12; ++i) {
    const Vector3 inside = 0.98 * (snapshot.positions->row(i).transpose() - Vector3(0.5, 0.5, 0));
    const Vector3 seen = camera.pose.orientation.conjugate() *
                         (inside + Vector3(0.5, 0.5, 0) - camera.pose.position);
    const int u = static_cast<int>(std::lround(camera.fx * seen.x() / seen.z() + camera.cx));
    const int v = static_cast<int>(std::lround(camera.fy * seen.y() / seen.z() + camera.cy));
    const Eigen::Vector2d expected(i % 4 / 3.0, i / 4 / 2.0);
    EXPECT_LT((pixel<2>(images, images.uv, u, v) - expected).norm(), 0.03) << i;
  }
}

TEST(Truth, UvOfARopeGoesAlongIt) {
  Snapshot snapshot = flat_cloth(30, 1);
  Camera camera = camera_with_fov(200, 60, 1);
  camera.pose = look_at({0.5, -0.4, 0}, {0.5, 0, 0});
  const Images images = draw_all(snapshot, camera);
  int on_rope = 0;
  for_each_pixel(camera, [&](int u, int v) {
    if (id(images, u, v) != 1) return;
    const double along = 0.5 + 0.4 * (u - camera.cx) / camera.fx;
    const double given = pixel<2>(images, images.uv, u, v).x();
    EXPECT_NEAR(given, along, snapshot.cloth->thickness + 0.01) << u << " " << v;
    ++on_rope;
  });
  EXPECT_GT(on_rope, 100);
}

// ---- Normals ----

/// In the optical frame, bent back where a smooth normal leans away from the camera.
Vector3 expected_normal(const Camera& camera, const Vector3& normal, const Vector3& ray) {
  const Vector3 along = ray.normalized();
  const Vector3 facing = normal - std::max(0.0, normal.dot(along)) * along;
  return camera.pose.orientation.conjugate() * facing.normalized();
}

TEST(Truth, NormalsAreThoseOfTheClothAndOfTheExactSphere) {
  Stage stage;
  stage.snapshot.colliders[0].segments = 8;  // a coarse mesh, which must have no effect
  const Images images = draw_all(stage.snapshot, stage.camera);
  const Vector3 eye = stage.camera.pose.position;
  const Vector3 centre = stage.snapshot.colliders[0].pose.position;
  int on_cloth = 0, on_sphere = 0;
  for_each_pixel(stage.camera, [&](int u, int v) {
    const Vector3 normal = pixel<3>(images, images.normals, u, v);
    const Vector3 ray = pixel_ray(stage.camera, u, v);
    const auto depth = double(images.depth[static_cast<std::size_t>(v * images.width + u)]);
    if (id(images, u, v) == 0) {
      EXPECT_TRUE(std::isnan(normal.x()) && std::isnan(normal.y()) && std::isnan(normal.z()));
      return;
    }
    EXPECT_NEAR(normal.norm(), 1, 1e-5);
    EXPECT_LT((stage.camera.pose.orientation * normal).dot(ray.normalized()), 1e-5);
    if (id(images, u, v) == 2) {
      const Vector3 radius = (eye + depth * ray - centre) / 0.3;
      EXPECT_LT((stage.camera.pose.orientation * normal - radius).norm(), 1e-5) << u << " " << v;
      ++on_sphere;
      return;
    }
    const auto hit = trace(stage.cloth, eye, ray);
    if (!hit || std::abs(hit->distance - depth) > 1e-4) return;  // a rim runs through the pixel
    const Vector3 expected = expected_normal(stage.camera, hit->normal, ray);
    EXPECT_LT((normal - expected).norm(), 1e-4) << u << " " << v;
    ++on_cloth;
  });
  EXPECT_GT(on_cloth, 2000);
  EXPECT_GT(on_sphere, 300);
}

/// Whether the shape has about this normal at a point of its surface, on the side of the ray's
/// origin. On an edge the normal of either face counts.
bool is_normal(const Shape& shape, const Vector3& at, const Vector3& normal, const Vector3& ray) {
  constexpr double aside = 2e-3;  // [m]
  for (int i = 0; i < 8; ++i) {
    const Vector3 near = at + aside * Vector3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    const Vector3 outward = signed_distance(shape, near, near).normal;
    if (normal.dot(outward.dot(ray) < 0 ? outward : Vector3(-outward)) > 0.98) return true;
  }
  return false;
}

TEST(Truth, NormalsOfEachShapeFaceTheCamera) {
  // From outside, and from within: planes and boxes exactly, round shapes to the accuracy of their
  // meshes.
  for (const Shape& shape :
       {Shape(Plane{}), Shape(Cuboid{{0.3, 0.2, 0.4}}), Shape(Capsule{0.5, 0.2}),
        Shape(Cylinder{0.5, 0.2}), Shape(Sphere{0.3}), test::mesh_shape(test::step_soup(0.4))}) {
    Snapshot snapshot;
    snapshot.colliders.resize(1);
    snapshot.colliders[0].shape = shape;
    for (const Vector3& eye : {Vector3(1, -1.5, 1.1), Vector3(0.01, 0.02, 0.03)}) {
      Camera camera = camera_with_fov(80, 60, 1);
      camera.pose = look_at(eye, {-0.3, 0.5, -0.2});
      const Images images = draw_all(snapshot, camera);
      int seen = 0;
      for_each_pixel(camera, [&](int u, int v) {
        if (id(images, u, v) == 0) return;
        ++seen;
        const Vector3 ray = pixel_ray(camera, u, v);
        const Vector3 normal = camera.pose.orientation * pixel<3>(images, images.normals, u, v);
        const auto depth = double(images.depth[static_cast<std::size_t>(v * images.width + u)]);
        EXPECT_TRUE(is_normal(shape, eye + depth * ray, normal, ray)) << u << " " << v;
        EXPECT_LT(normal.dot(ray), 1e-5);
      });
      EXPECT_GT(seen, 100);
    }
  }
}

TEST(Truth, NormalsOfADisplacedSurfaceAreThoseOfItsTriangles) {
  // Height grows with u: a plane that is tilted.
  Snapshot snapshot = flat_cloth(6, 6);
  Displacement displacement;
  const auto slope = std::make_shared<HeightMap>();
  slope->width = slope->height = 64;
  for (int i = 0; i < 64 * 64; ++i) slope->heights.push_back(static_cast<float>(i % 64) / 63);
  displacement.height_map = slope;
  displacement.height_scaling = 0.3;
  snapshot.cloth_shading = displacement;
  Camera camera = camera_with_fov(80, 60, 0.5);
  camera.pose = look_at({0.5, 0.5, 2}, {0.5, 0.5, 0});
  const Images images = draw_all(snapshot, camera);
  const Vector3 normal = camera.pose.orientation * pixel<3>(images, images.normals, 40, 30);
  EXPECT_LT((normal - Vector3(-0.3, 0, 1).normalized()).norm(), 0.02);
}

// ---- Together ----

TEST(Truth, EachImageIsTheSameAloneAndWithOthers) {
  Stage stage;
  const Images all = draw_all(stage.snapshot, stage.camera);
  const auto same = [](const std::vector<float>& one, const std::vector<float>& other) {
    return one.size() == other.size() && !one.empty() &&
           std::memcmp(one.data(), other.data(), one.size() * sizeof(float)) == 0;
  };
  const auto draw_one = [&](bool WantedImages::*image) {
    WantedImages wanted{false, false, false};
    wanted.*image = true;
    Images images;
    shared_renderer().render(stage.snapshot, stage.camera, wanted, images);
    EXPECT_TRUE(images.color.empty() && images.depth.empty() && images.mask.empty());
    return images;
  };
  EXPECT_TRUE(same(draw_one(&WantedImages::uv).uv, all.uv));
  EXPECT_TRUE(same(draw_one(&WantedImages::normals).normals, all.normals));

  const Images usual = draw(stage.snapshot, stage.camera);
  EXPECT_EQ(usual.color, all.color);
  EXPECT_EQ(usual.depth, all.depth);
  EXPECT_EQ(usual.mask, all.mask);
  EXPECT_TRUE(usual.uv.empty() && usual.normals.empty() && usual.flow.empty());
}

}  // namespace
}  // namespace clothsim::truth_test
