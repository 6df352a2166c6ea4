// Depth noise by its statistics: bounds are 4 standard errors wide.

#include "clothsim/render/depth_noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "render_fixture.h"

namespace clothsim::depth_noise_test {
namespace {

constexpr std::size_t count = 200000;
constexpr double kinect = 1.425e-3;  // [m]

/// Errors in standard deviations of pixels that all have one depth [m].
std::vector<double> errors(const DepthNoise& noise, double time, double depth) {
  std::vector<float> image(count, static_cast<float>(depth));
  add_noise(noise, time, 0.05, image);
  std::vector<double> errors;
  for (const float z : image) errors.push_back((double(z) - depth) / (noise.sigma * depth * depth));
  return errors;
}

double mean_product(const std::vector<double>& a, const std::vector<double>& b,
                    std::size_t shift = 0) {
  double sum = 0;
  for (std::size_t i = 0; i + shift < a.size(); ++i) sum += a[i] * b[i + shift];
  return sum / static_cast<double>(a.size() - shift);
}

TEST(DepthNoise, IsNormalWithADeviationThatGrowsAsTheSquareOfDepth) {
  const double n = count;
  for (const double depth : {0.5, 1.0, 2.0, 5.0}) {
    const std::vector<double> e = errors({kinect, 3}, 0.1, depth);
    double mean = 0, fourth = 0, beyond = 0;
    for (const double x : e) {
      mean += x / n;
      fourth += x * x * x * x / n;
      beyond += (std::abs(x) > 2) / n;
    }
    EXPECT_NEAR(mean, 0, 4 / std::sqrt(n)) << depth;
    EXPECT_NEAR(mean_product(e, e), 1, 4 * std::sqrt(2 / n)) << depth;
    EXPECT_NEAR(fourth, 3, 4 * std::sqrt(96 / n)) << depth;  // E x^8 - 9 = 96
    EXPECT_NEAR(beyond, std::erfc(std::sqrt(2.0)), 4 * std::sqrt(0.0455 / n)) << depth;
  }
}

TEST(DepthNoise, OfPixelsPicturesAndSeedsHaveNothingToDoWithEachOther) {
  const std::vector<double> e = errors({kinect, 3}, 0.1, 1);
  const double bound = 4 / std::sqrt(double(count));
  for (const std::size_t shift : {std::size_t{1}, std::size_t{2}, std::size_t{640}})
    EXPECT_NEAR(mean_product(e, e, shift), 0, bound) << shift;
  for (const double time : {0.0, -0.1, 0.1 + 1 / 90.0, std::nextafter(0.1, 1.0)})
    EXPECT_NEAR(mean_product(e, errors({kinect, 3}, time, 1)), 0, bound) << time;
  for (const std::uint64_t seed : {std::uint64_t{0}, std::uint64_t{4}, ~std::uint64_t{0}})
    EXPECT_NEAR(mean_product(e, errors({kinect, seed}, 0.1, 1)), 0, bound) << seed;
  EXPECT_EQ(e, errors({kinect, 3}, 0.1, 1));
}

TEST(DepthNoise, LeavesNothingAsItIsAndStaysBeyondTheNearPlane) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  std::vector<float> depth(1000, 1.0F);
  depth[7] = infinity;
  add_noise({1, 0}, 0, 0.5, depth);
  EXPECT_EQ(depth[7], infinity);
  for (const float z : depth) EXPECT_GE(z, 0.5F);
  EXPECT_GT(std::count(depth.begin(), depth.end(), 0.5F), 100);  // a third is 0.5 sigma below
  const std::vector<float> before = depth;
  add_noise({0, 5}, 0, 0.5, depth);
  EXPECT_EQ(depth, before);
}

TEST(DepthNoise, IsInTheDepthImageAlone) {
  Snapshot snapshot = flat_cloth(5, 5);
  snapshot.time = 0.3;
  Camera camera = camera_with_fov(96, 72, 1);
  camera.pose = look_at({0.5, 0.5, 2}, {0.5, 0.5, 0});
  const Images exact = draw(snapshot, camera);
  camera.depth_noise = {kinect, 1};
  const Images noisy = draw(snapshot, camera);
  EXPECT_EQ(noisy.color, exact.color);
  EXPECT_EQ(noisy.mask, exact.mask);
  std::vector<float> expected = exact.depth;
  add_noise(camera.depth_noise, 0.3, camera.near, expected);
  EXPECT_EQ(noisy.depth, expected);
  EXPECT_NE(noisy.depth, exact.depth);
  EXPECT_EQ(draw(snapshot, camera).depth, noisy.depth);
  snapshot.time = 0.31;
  EXPECT_NE(draw(snapshot, camera).depth, noisy.depth);
}

}  // namespace
}  // namespace clothsim::depth_noise_test
