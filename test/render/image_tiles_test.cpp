#include "clothsim/render/image_tiles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

namespace clothsim::image_tiles_test {
namespace {

std::set<int> numbers(const ImageTiles& tiles, const ImageTiles::Block& block) {
  std::set<int> all;
  tiles.for_each(block, [&](int tile) { all.insert(tile); });
  return all;
}

TEST(ImageTiles, HaveEachPixelInOne) {
  Camera camera;
  camera.width = 50;
  camera.height = 31;
  for (const std::size_t number : {0u, 1u, 7u, 100u, 1550u, 1000000u}) {
    const ImageTiles tiles(camera, number);
    std::set<int> seen;
    for (int v = 0; v < camera.height; ++v)
      for (int u = 0; u < camera.width; ++u) seen.insert(tiles.tile_at({u, v}));
    EXPECT_EQ(static_cast<int>(seen.size()), tiles.num_tiles()) << number;
    EXPECT_EQ(*seen.begin(), 0);
    EXPECT_EQ(*seen.rbegin(), tiles.num_tiles() - 1);
  }
}

TEST(ImageTiles, CoverWhatACameraSeesOfATriangle) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> share(0, 1);
  Camera camera = camera_with_fov(64, 48, 1.2);
  camera.near = 0.3;
  const ImageTiles tiles(camera, 300);
  int inside = 0, partly = 0, most = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    std::array<Vector3, 3> triangle;
    const Vector3 middle(normal(random), normal(random), normal(random));
    for (Vector3& corner : triangle) {
      corner = middle + 0.3 * Vector3(normal(random), normal(random), normal(random));
    }
    const std::set<int> covered = numbers(tiles, tiles.covered(seen_box(camera, triangle)));
    most += static_cast<int>(covered.size());
    for (int sample = 0; sample < 50; ++sample) {
      const double root = std::sqrt(share(random)), part = share(random);
      const Vector3 p =
          (1 - root) * triangle[0] + root * (1 - part) * triangle[1] + root * part * triangle[2];
      if (p.z() < camera.near) {
        ++partly;
        continue;
      }
      const Eigen::Vector2d pixel = pixel_of(camera, p);
      if ((pixel.array() < -0.5).any() || pixel.x() >= 63.5 || pixel.y() >= 47.5) continue;
      ++inside;
      EXPECT_TRUE(covered.count(tiles.tile_at(pixel))) << pixel.transpose();
    }
  }
  EXPECT_GT(inside, 5000);
  EXPECT_GT(partly, 10000);
  EXPECT_LT(most, 2000 * 60);  // not simply all 300
}

TEST(ImageTiles, OfATriangleBehindTheNearPlaneOrBesideTheImageAreNone) {
  const Camera camera = camera_with_fov(64, 48, 1.2);
  const ImageTiles tiles(camera, 300);
  const auto none = [&](const Vector3& a, const Vector3& b, const Vector3& c) {
    return tiles.covered(seen_box(camera, {a, b, c})).empty();
  };
  EXPECT_TRUE(none({0, 0, 0.01}, {1, 0, -1}, {0, 1, -2}));
  EXPECT_TRUE(none({9, 0, 1}, {10, 0, 1}, {9, 1, 1}));
  EXPECT_TRUE(none({0, -9, 1}, {1, -9, 1}, {0, -8, 1}));
  EXPECT_FALSE(none({-9, 0, 1}, {9, 0, 1}, {0, 1, -1}));
}

}  // namespace
}  // namespace clothsim::image_tiles_test
