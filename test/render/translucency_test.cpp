#include "clothsim/render/translucency.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include "clothsim/geometry/rays.h"
#include "render_fixture.h"

namespace clothsim::translucency_test {
namespace {

std::shared_ptr<const Image> plain_image(std::uint8_t r, std::uint8_t g, std::uint8_t b) {
  auto image = std::make_shared<Image>();
  *image = {1, 1, {r, g, b}};
  return image;
}

/// Layers of one colour without light: all light is ambient, ka Ia = `level`, on `alpha`.
Translucent layer(double alpha, double level) {
  Translucent shading;
  shading.image = plain_image(255, 255, 255);
  shading.phong = {level, 0, 0, 1};
  shading.alpha = alpha;
  return shading;
}

Camera above() {
  Camera camera = camera_with_fov(40, 30, 0.8);
  camera.pose = look_at({0.5, 0.5, 3}, {0.5, 0.5, 0});
  return camera;
}

/// A square parallel to the ground around the middle of the picture.
ColliderView square(double height, const Shading& shading) {
  ColliderView view;
  view.shape = Plane{};
  view.extent = 1;
  view.segments = 4;
  view.pose.position = {0.5, 0.5, height};
  view.shading = shading;
  return view;
}

TEST(Translucency, TwoLayersBlendFarToNearWhateverTheirOrderInTheScene) {
  // C = a1 L1 + (1 - a1) (a2 L2 + (1 - a2) B), layer 1 the nearer one, in linear light.
  Snapshot snapshot;
  snapshot.light.ambient = 1;
  snapshot.background.color = {0, 0, 0.5};
  const ColliderView near = square(1, layer(0.3, 0.9)), far = square(0.2, layer(0.6, 0.2));
  for (const bool near_first : {true, false}) {
    snapshot.colliders = near_first ? std::vector{near, far} : std::vector{far, near};
    const Images images = draw(snapshot, above());
    const auto blended = [](double background) {
      return 0.3 * 0.9 + 0.7 * (0.6 * 0.2 + 0.4 * background);
    };
    EXPECT_NEAR(channel(images, 20, 15, 0), srgb_byte(blended(0)), 2);
    EXPECT_NEAR(channel(images, 20, 15, 2), srgb_byte(blended(linear_of_srgb(0.5))), 2);
  }
}

TEST(Translucency, LayersOfOneFoldedClothBlendFarToNear) {
  // Two squares of one cloth, the lower one listed last, both sides lit by their own height.
  Points positions(8, 3);
  for (int i = 0; i < 8; ++i) positions.row(i) << i % 2, (i / 2) % 2, i < 4 ? 1.0 : 0.2;
  Snapshot snapshot = triangle_cloth(positions, {{0, 1, 3}, {0, 3, 2}, {4, 5, 7}, {4, 7, 6}});
  // Diffuse light from above: the higher layer is brighter.
  Translucent shading = layer(0.5, 0);
  shading.phong.kd = 1;
  snapshot.cloth_shading = shading;
  snapshot.light = {{0.5, 0.5, 2}, 0.5, 0};
  snapshot.background.color = {0, 0, 0};
  const Images images = draw(snapshot, above());
  const double upper = 0.5 / 1, lower = 0.5 / (1.8 * 1.8);
  EXPECT_NEAR(channel(images, 20, 15, 0), srgb_byte(0.5 * upper + 0.5 * 0.5 * lower), 2);
}

TEST(Translucency, WhatIsSolidHidesAndIsSeenThrough) {
  Snapshot snapshot;
  snapshot.light = {{0.5, 0.5, 3}, 0, 1};
  Cartoon solid;
  solid.color = {1, 0, 0};
  solid.kd = 0;
  solid.ambient = 1;
  const ColliderView veil = square(0.5, layer(0.5, 0.4));
  snapshot.colliders = {veil, square(0, solid)};  // seen through the veil
  EXPECT_NEAR(channel(draw(snapshot, above()), 20, 15, 0), srgb_byte(0.5 * 0.4 + 0.5), 2);
  snapshot.colliders = {veil, square(1, solid)};  // in front of it
  EXPECT_EQ(channel(draw(snapshot, above()), 20, 15, 0), 255);
  EXPECT_EQ(channel(draw(snapshot, above()), 20, 15, 1), 0);
}

TEST(Translucency, ByLightTheLitPartsAreMoreTransparent) {
  // alpha = 1 + (0.5 - 1) min(1, (I / r^2) n.l): straight below the light at 2 m, I / r^2 = I / 4.
  Snapshot snapshot;
  snapshot.background.color = {0, 0, 1};
  Translucent shading = layer(0.5, 0);
  shading.by_light = true;
  snapshot.colliders = {square(0, shading)};
  for (const double irradiance : {0.0, 0.4, 1.0, 3.0}) {
    snapshot.light = {{0.5, 0.5, 2}, 4 * irradiance, 0};
    const double alpha = 1 - 0.5 * std::min(1.0, irradiance);
    EXPECT_NEAR(channel(draw(snapshot, above()), 20, 15, 2), srgb_byte(1 - alpha), 2) << irradiance;
  }
}

TEST(Translucency, DepthAndMaskTakeTheNearestLayer) {
  Snapshot snapshot;
  snapshot.colliders = {square(0, layer(0.5, 1)), square(1, layer(0.5, 1))};
  const Images images = draw(snapshot, above());
  const std::size_t middle = 15 * 40 + 20;
  EXPECT_NEAR(images.depth[middle], 2, 1e-5);
  EXPECT_EQ(images.mask[middle], 3);
}

/// An object whose triangles are three points each, in order.
DrawItem loose_triangles(const Points& positions, std::vector<std::array<int, 3>>& triangles) {
  const auto count = static_cast<int>(positions.rows() / 3);
  for (int k = 0; k < count; ++k) triangles.push_back({3 * k, 3 * k + 1, 3 * k + 2});
  DrawItem item{};
  item.positions = &positions;
  item.triangles = &triangles;
  item.own_points = {0, 3 * count};
  item.own_triangles = {0, count};
  item.rotation = Eigen::Matrix3d::Identity();
  item.translation = Vector3::Zero();
  return item;
}

TEST(Translucency, SortsTrianglesOfAllObjectsTogether) {
  // Two objects whose triangles interleave in depth.
  Points a(6, 3), b(3, 3);
  a << 0, 0, 1, 1, 0, 1, 0, 1, 1, 0, 0, 3, 1, 0, 3, 0, 1, 3;
  b << 0, 0, 0, 1, 0, 0, 0, 1, 0;
  std::vector<std::array<int, 3>> two, one;
  const DrawItem first = loose_triangles(a, two);
  DrawItem second = loose_triangles(b, one);
  second.translation = {0, 0, 2};

  const BackToFront order = sort_back_to_front({&first, &second}, camera_with_fov(40, 30, 1));
  ASSERT_EQ(order.runs.size(), 3u);
  EXPECT_EQ(order.runs[0].item, &first);
  EXPECT_EQ(order.runs[1].item, &second);
  EXPECT_EQ(order.runs[2].item, &first);
  ASSERT_EQ(order.triangles.size(), 3u);
  EXPECT_EQ(order.triangles[0], two[1]);
  EXPECT_EQ(order.triangles[1], one[0]);
  EXPECT_EQ(order.triangles[2], two[0]);
}

/// Depth of a triangle at the centre of a pixel [m]; empty: the triangle is not drawn there.
std::optional<double> depth_at(const Camera& c, double u, double v, const DrawItem& item,
                               const std::array<int, 3>& corners) {
  std::array<Vector3, 3> triangle;
  for (std::size_t k = 0; k < 3; ++k)
    triangle[k] = Vector3(item.positions->row(corners[k])) + item.translation;
  const double depth =
      hit_by_ray(Vector3::Zero(), {(u - c.cx) / c.fx, (v - c.cy) / c.fy, 1}, triangle);
  if (depth < c.near || std::isinf(depth)) return std::nullopt;
  return depth;
}

TEST(Translucency, InEachPixelTrianglesKeepTheOrderOfTheirDepths) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const Camera camera = camera_with_fov(24, 18, 1);
  std::array<Points, 3> positions;
  std::array<std::vector<std::array<int, 3>>, 3> triangles;
  std::vector<DrawItem> items;
  for (std::size_t i = 0; i < 3; ++i) {
    positions[i].resize(3 * 60, 3);
    for (int k = 0; k < 60; ++k) {
      const double size = k % 10 ? 0.1 : 2;  // some surround the camera
      for (int corner = 0; corner < 3; ++corner)
        positions[i].row(3 * k + corner) << size * normal(random), size * normal(random),
            size * normal(random);
      const Eigen::RowVector3d middle(normal(random), normal(random), 3 + normal(random));
      positions[i].middleRows(3 * k, 3).rowwise() += middle;
    }
    items.push_back(loose_triangles(positions[i], triangles[i]));
  }
  const BackToFront order = sort_back_to_front({&items[0], &items[1], &items[2]}, camera);
  EXPECT_LT(order.runs.size(), 60u);  // 120 at random

  const auto centroid = [](const DrawItem& item, const std::array<int, 3>& corners) {
    double depth = 0;
    for (const int corner : corners) depth += (*item.positions)(corner, 2) / 3;
    return depth;
  };
  int layers = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      double last = std::numeric_limits<double>::infinity();
      int drawn = 0, expected = 0;
      for (const BackToFront::Run& run : order.runs) {
        for (int k = run.first; k < run.first + run.count; ++k) {
          const auto& corners = order.triangles[static_cast<std::size_t>(k)];
          if (!depth_at(camera, u, v, *run.item, corners)) continue;
          const double depth = centroid(*run.item, corners);
          EXPECT_LE(depth, last) << u << " " << v;
          last = depth;
          ++drawn;
        }
      }
      for (const DrawItem& item : items)
        for (const auto& corners : *item.triangles)
          if (depth_at(camera, u, v, item, corners)) ++expected;
      EXPECT_EQ(drawn, expected) << u << " " << v;
      layers += drawn;
    }
  }
  EXPECT_GT(layers, 1000);
}

}  // namespace
}  // namespace clothsim::translucency_test
