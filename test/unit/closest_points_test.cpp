#include "clothsim/geometry/closest_points.h"

#include "verification/testing.h"

namespace clothsim::closest_points_test {
namespace {

using namespace test;

using Corners = std::array<Vector3, 3>;

double to_triangle(const Vector3& p, const Corners& t) {
  const auto [u, v, w] = closest_on_triangle(p, t[0], t[1], t[2]);
  EXPECT_GE(std::min({u, v, w}), 0);
  EXPECT_NEAR(u + v + w, 1, 1e-12);
  return (p - u * t[0] - v * t[1] - w * t[2]).norm();
}

double between_segments(const std::array<Vector3, 4>& p) {
  const auto [s, t] = closest_on_segments(p[0], p[1], p[2], p[3]);
  EXPECT_TRUE(s >= 0 && s <= 1 && t >= 0 && t <= 1) << s << ' ' << t;
  return ((1 - s) * p[0] + s * p[1] - (1 - t) * p[2] - t * p[3]).norm();
}

/// Minimum of a convex f(x, y) over the square or the triangle x + y <= 1, by nested golden-section
/// searches: accurate to 1e-7 for any formula.
template <typename Function>
double minimum(bool triangle, const Function& f) {
  const auto section = [](double high, const auto& g) {
    constexpr double golden = 0.6180339887498949;
    double low = 0;
    for (int i = 0; i < 60; ++i) {
      const double a = high - golden * (high - low), b = low + golden * (high - low);
      (g(a) < g(b) ? high : low) = g(a) < g(b) ? b : a;
    }
    return g((low + high) / 2);
  };
  return section(1, [&](double x) {
    return section(triangle ? 1 - x : 1, [&](double y) { return f(x, y); });
  });
}

TEST(ClosestPoints, OfATriangleAreNoFartherThanAMinimiserFinds) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const Points x = random_points(4, 1, seed);
    Corners t;
    for (int i = 0; i < 3; ++i) t[static_cast<std::size_t>(i)] = x.row(i).transpose();
    if (seed % 4 == 1) t[2] = t[0] + 1e-3 * (t[1] - t[0]).cross(Vector3::UnitX());  // a sliver
    if (seed % 4 == 2) t[2] = 0.3 * t[0] + 0.7 * t[1];                              // a line
    if (seed % 12 == 3) t[1] = t[2] = t[0];                                         // a point
    const Vector3 p = x.row(3).transpose();
    const double least = minimum(true, [&](double v, double w) {
      return (p - (1 - v - w) * t[0] - v * t[1] - w * t[2]).norm();
    });
    EXPECT_NEAR(to_triangle(p, t), least, 1e-6) << seed;
  }
}

TEST(ClosestPoints, OfSegmentsAreNoFartherThanAMinimiserFinds) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const Points x = random_points(4, 1, seed);
    std::array<Vector3, 4> p;
    for (int i = 0; i < 4; ++i) p[static_cast<std::size_t>(i)] = x.row(i).transpose();
    if (seed % 4 == 1) p[3] = p[2] + 0.7 * (p[1] - p[0]);        // parallel
    if (seed % 4 == 2) p[3] = p[2] + p[1] - p[0] + 1e-6 * p[2];  // nearly
    if (seed % 12 == 3) p[1] = p[0];                             // a point
    if (seed % 12 == 7) p[1] = p[0], p[3] = p[2];                // two
    const double least = minimum(false, [&](double s, double t) {
      return ((1 - s) * p[0] + s * p[1] - (1 - t) * p[2] - t * p[3]).norm();
    });
    EXPECT_NEAR(between_segments(p), least, 1e-6) << seed;
  }
}

TEST(ClosestPoints, WeightsAreExactlyZeroOffACornerOrAnEdge) {
  const Vector3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  const std::array<double, 3> corner{0, 1, 0};
  EXPECT_EQ(closest_on_triangle({2, -0.5, 1}, a, b, c), corner);
  const auto [u, v, w] = closest_on_triangle({0.25, -1, 1}, a, b, c);
  EXPECT_EQ(w, 0);
  EXPECT_DOUBLE_EQ(u, 0.75);
  EXPECT_DOUBLE_EQ(v, 0.25);
}

}  // namespace
}  // namespace clothsim::closest_points_test
