// What the images of the surfaces hold beside depth and mask (pixels_test.cpp), against the ray
// through each pixel's centre.

#include <gtest/gtest.h>

#include <cmath>

#include "clothsim/model/grid.h"
#include "stage.h"

namespace clothsim {
namespace {

WantedImages everything() {
  WantedImages wanted;
  wanted.uv = true;
  return wanted;
}

Images draw_all(const Snapshot& snapshot, const Camera& camera) {
  Images images;
  shared_renderer().render(snapshot, camera, everything(), images);
  return images;
}

/// The values of pixel (u, v) of an image with two or three a pixel.
template <int channels>
Eigen::Matrix<double, channels, 1> pixel(const Images& images, const std::vector<float>& image,
                                         int u, int v) {
  Eigen::Matrix<double, channels, 1> values;
  for (int c = 0; c < channels; ++c)
    values[c] = double(image[static_cast<std::size_t>(channels * (v * images.width + u) + c)]);
  return values;
}

int id(const Images& images, int u, int v) {
  return images.mask[static_cast<std::size_t>(v * images.width + u)];
}

/// Calls visit(u, v) for each pixel.
template <class Visit>
void for_each_pixel(const Camera& camera, const Visit& visit) {
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) visit(u, v);
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
    if (std::abs(hit->distance - double(depth)) > 1e-4) return;  // as does the rim of a fold
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

// ---- Together ----

TEST(Truth, EachImageIsTheSameAloneAndWithOthers) {
  Stage stage;
  const Images all = draw_all(stage.snapshot, stage.camera);
  WantedImages wanted{false, false, false};
  wanted.uv = true;
  Images uv;
  shared_renderer().render(stage.snapshot, stage.camera, wanted, uv);
  EXPECT_TRUE(uv.color.empty() && uv.depth.empty() && uv.mask.empty());
  ASSERT_EQ(uv.uv.size(), all.uv.size());
  for (std::size_t i = 0; i < uv.uv.size(); ++i)
    EXPECT_TRUE(uv.uv[i] == all.uv[i] || (std::isnan(uv.uv[i]) && std::isnan(all.uv[i])));

  const Images usual = draw(stage.snapshot, stage.camera);
  EXPECT_EQ(usual.color, all.color);
  EXPECT_EQ(usual.depth, all.depth);
  EXPECT_EQ(usual.mask, all.mask);
  EXPECT_TRUE(usual.uv.empty());
}

}  // namespace
}  // namespace clothsim
