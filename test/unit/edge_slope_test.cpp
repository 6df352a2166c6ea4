// The slope across an edge from the heights of points around it.

#include "clothsim/model/edge_slope.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace clothsim::edge_slope_test {
namespace {

/// An edge of a mesh of equilateral triangles with all eight points, moved at random by up to
/// `uneven`.
std::vector<PointAtEdge> around_edge(double uneven, unsigned seed = 1) {
  const double h = std::sqrt(3) / 2;
  const Eigen::Vector2d places[] = {{-0.5, 0}, {0.5, 0}, {0, -h}, {0, h},
                                    {-1, -h},  {1, -h},  {-1, h}, {1, h}};
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> by(-uneven, uneven);
  std::vector<PointAtEdge> points;
  for (const Eigen::Vector2d& place : places) {
    const Eigen::Vector2d shift(by(random), by(random));
    const bool is_end = points.size() < 2;
    points.push_back({static_cast<int>(points.size()), is_end ? place : place + shift});
  }
  return points;
}

/// Error of the slope of a x^2 + b x y + c y^2 + 2 - 3 x + 5 y.
double error_of(const std::vector<PointAtEdge>& points, double a, double b, double c) {
  double slope = 0;
  for (const auto& [point, share] : slope_across(points)) {
    const Eigen::Vector2d& p = points[static_cast<std::size_t>(point)].place;
    slope += share * (a * p.x() * p.x() + b * p.x() * p.y() + c * p.y() * p.y() + 2 - 3 * p.x() +
                      5 * p.y());
  }
  return std::abs(slope - 5);
}

TEST(EdgeSlope, IsExactForQuadraticFunctions) {
  int corrected = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    const auto points = around_edge(0.25, seed);
    const bool is_corrected = slope_across(points).size() == 8;
    corrected += is_corrected;
    const double tolerance = is_corrected ? 1e-12 : 0.05;  // where points are nearly even
    EXPECT_LT(error_of(points, 1, 0, 0), tolerance) << seed;
    EXPECT_LT(error_of(points, 0, 1, 0), tolerance) << seed;
    EXPECT_LT(error_of(points, 0, 0, 1), 1e-12) << seed;
  }
  EXPECT_GT(corrected, 80);
}

TEST(EdgeSlope, HasFourPointsOnEvenMeshes) {
  EXPECT_EQ(slope_across(around_edge(0)).size(), 4U);
  EXPECT_EQ(slope_across(around_edge(0.01)).size(), 4U);
  EXPECT_LT(error_of(around_edge(0.01), 1, 1, 1), 0.1);
  EXPECT_EQ(slope_across(around_edge(0.25)).size(), 8U);
}

TEST(EdgeSlope, IsTheMeanInEquilibriumOfTwoTrianglesOfOtherHeights) {
  // Heights 1 and 3 over and under the edge: slopes -2 and 6 weigh as 1 and 3.
  const std::vector<PointAtEdge> points{{0, {-0.5, 0}}, {1, {0.5, 0}}, {2, {0, -3}}, {3, {0, 1}}};
  double slope = 0;
  const double heights[] = {0, 0, 6, 6};
  for (const auto& [point, share] : slope_across(points)) slope += share * heights[point];
  EXPECT_NEAR(slope, (1 * -2 + 3 * 6) / 4.0, 1e-14);
  EXPECT_LT(error_of(points, 0, 0, 1), 1e-14);
}

TEST(EdgeSlope, IsExactForLinearFunctionsWhateverThePoints) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    auto points = around_edge(0.8, seed);
    points[2].place.y() = -0.01 - std::abs(points[2].place.y());
    points[3].place.y() = 0.01 + std::abs(points[3].place.y());
    points.resize(4 + seed % 5);
    EXPECT_LT(error_of(points, 0, 0, 0), 1e-9) << seed;
  }
}

TEST(EdgeSlope, IsNotCorrectedBesideASliver) {
  auto points = around_edge(0.2);
  points[2].place = {0.1, -1e-3};
  EXPECT_EQ(slope_across(points).size(), 4U);
}

TEST(EdgeSlope, HasNoLargeSharesWherePointsDoNotDetermineThem) {
  // All points are on the conic x y = y^2: no correction for this function is possible.
  std::vector<PointAtEdge> points{{0, {-0.5, 0}},  {1, {0.5, 0}},   {2, {-0.8, -0.8}},
                                  {3, {0.6, 0.6}}, {4, {1.2, 1.2}}, {5, {-1.5, -1.5}}};
  double largest = 0;
  for (const auto& [point, share] : slope_across(points)) {
    largest = std::max(largest, std::abs(share));
  }
  EXPECT_LT(largest, 10);
}

}  // namespace
}  // namespace clothsim::edge_slope_test
