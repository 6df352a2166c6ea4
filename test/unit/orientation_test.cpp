// The exact sign of a determinant: against integers, known planes and its own symmetries.

#include "clothsim/geometry/orientation.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

namespace clothsim::orientation_test {
namespace {

using Points4 = std::array<Vector3, 4>;

int orientation(const Points4& p) { return clothsim::orientation(p[0], p[1], p[2], p[3]); }

/// Every order of the four points has the sign of the order's parity.
void expect_alternating(const Points4& points, int sign) {
  std::array<std::size_t, 4> order{0, 1, 2, 3};
  do {
    int inversions = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) inversions += order[i] > order[j];
    }
    const int expected = inversions % 2 == 0 ? sign : -sign;
    ASSERT_EQ(orientation({points[order[0]], points[order[1]], points[order[2]], points[order[3]]}),
              expected);
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(Orientation, IsPositiveWhereTheTriangleIsSeenCounterClockwise) {
  const Vector3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  EXPECT_EQ(orientation({a, b, c, {5, -7, 1e-9}}), 1);
  EXPECT_EQ(orientation({a, b, c, {5, -7, -1e-9}}), -1);
  EXPECT_EQ(orientation({a, b, c, {5, -7, 0}}), 0);
  EXPECT_EQ(orientation({a, b, 2 * b, {5, -7, 1}}), 0);  // a line
  EXPECT_EQ(orientation({a, a, a, {5, -7, 1}}), 0);      // a point
}

__extension__ typedef __int128 Wide;

int exact_sign(const std::array<std::array<Wide, 3>, 4>& p) {
  std::array<std::array<Wide, 3>, 3> d;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) d[i][axis] = p[i + 1][axis] - p[0][axis];
  }
  const auto& [b, c, e] = d;
  const Wide determinant = (b[1] * c[2] - b[2] * c[1]) * e[0] + (b[2] * c[0] - b[0] * c[2]) * e[1] +
                           (b[0] * c[1] - b[1] * c[0]) * e[2];
  return determinant > 0 ? 1 : determinant < 0 ? -1 : 0;
}

TEST(Orientation, EqualsTheDeterminantOfIntegers) {
  // d is nearly a combination of a, b, c, so that the sign depends on the last bits of numbers of
  // 40 bits; products of three fit into 128.
  std::mt19937_64 random(1);
  const auto integer = [&random](int bits) {
    return static_cast<std::int64_t>(random() >> (64 - bits)) - (std::int64_t{1} << (bits - 1));
  };
  std::array<int, 3> seen{};
  for (int trial = 0; trial < 20000; ++trial) {
    std::array<std::array<Wide, 3>, 4> exact;
    Points4 points;
    const std::int64_t s = integer(2), t = integer(2);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::array<std::int64_t, 4> x{integer(38), integer(38), integer(38), 0};
      x[3] = x[0] + s * (x[1] - x[0]) + t * (x[2] - x[0]) + integer(2) / 2;
      for (std::size_t i = 0; i < 4; ++i) {
        exact[i][axis] = x[i];
        points[i][static_cast<Eigen::Index>(axis)] = std::ldexp(static_cast<double>(x[i]), -30);
      }
    }
    const int sign = exact_sign(exact);
    ++seen[static_cast<std::size_t>(sign + 1)];
    ASSERT_EQ(orientation(points), sign) << trial;
  }
  for (const int count : seen) EXPECT_GT(count, 1000);  // each sign came up
}

TEST(Orientation, StaysInItsBoundsBeyondItsRange) {
  // A cloth that diverges is still counted: only the sign is lost when the products overflow.
  std::mt19937_64 random(3);
  for (const double size : {1e150, 1e307, 1e-150, 1e-307}) {
    for (int trial = 0; trial < 1000; ++trial) {
      Points4 points;
      for (Vector3& p : points) {
        for (double& x : p)
          x = size * static_cast<double>(static_cast<std::int64_t>(random())) / 1e19;
      }
      EXPECT_LE(std::abs(orientation(points)), 1);
    }
  }
}

TEST(Orientation, KnowsAPlaneToTheLastBitAtEveryMagnitude) {
  // Points of the plane z = x, of magnitudes so mixed that their differences are rounded; then one
  // of them is moved off the plane by one unit in the last place.
  std::mt19937_64 random(2);
  const auto number = [&random](double least, double most) {
    std::uniform_real_distribution<double> exponent(std::log(least), std::log(most));
    return (random() % 2 ? 1 : -1) * std::exp(exponent(random));
  };
  for (const auto& [least, most] :
       {std::pair(1e-9, 1e6), std::pair(0.5, 1.0), std::pair(1e-70, 1e-60), std::pair(1e5, 1e90),
        std::pair(1e6, 1.00000000001e6)}) {
    for (int trial = 0; trial < 500; ++trial) {
      Points4 points;
      for (Vector3& p : points) {
        const double x = number(least, most);
        p = {x, number(least, most), x};
      }
      expect_alternating(points, 0);
      const Vector3 normal = (points[1] - points[0]).cross(points[2] - points[0]);
      if (!(normal.norm() > 0)) continue;

      // Above z = x lies the side of (-1, 0, 1); is it that of a, b, c counter-clockwise? By the
      // sign of an area in a projection along y or x, exact once the plane z = x is turned into z =
      // 0.
      Points4 flat = points;
      for (Vector3& p : flat) p.z() = 0;
      flat[3].z() = 1;
      const int up = orientation(flat);
      points[3].z() = std::nextafter(points[3].x(), 1e300);
      expect_alternating(points, up);
      points[3].z() = std::nextafter(points[3].x(), -1e300);
      expect_alternating(points, -up);
    }
  }
}

}  // namespace
}  // namespace clothsim::orientation_test
