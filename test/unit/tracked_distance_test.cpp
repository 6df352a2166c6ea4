#include "clothsim/shapes/tracked_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "clothsim/geometry/intersections.h"

namespace clothsim::tracked_distance_test {
namespace {

std::vector<Shape> solids(double scale) {
  const auto box = [&](double x, double y, double z) { return Cuboid{scale * Vector3(x, y, z)}; };
  const auto cylinder = [&](double length, double radius) {
    return Cylinder{scale * length, scale * radius};
  };
  return {Sphere{0.3 * scale}, Capsule{0.8 * scale, 0.2 * scale},
          box(1.2, 0.8, 0.4),  box(0.8, 0.8, 0.01),
          cylinder(0.8, 0.3),  cylinder(0.02, 0.4),
          cylinder(1.2, 0.02)};
}

Vector3 at(const Triangle& t, const std::array<double, 3>& w) {
  return w[0] * t[0] + w[1] * t[1] + w[2] * t[2];
}

class RandomMotion {
 public:
  explicit RandomMotion(std::uint64_t seed) : engine_(seed) {}

  /// Within about a `spread` of the origin [m].
  Triangle triangle(double size, double spread) {
    const Vector3 middle = vector(0.8 * spread);
    return {middle + vector(size), middle + vector(size), middle + vector(size)};
  }

  Triangle moved(Triangle t, double by) {
    const Vector3 way = vector(by);
    for (Vector3& p : t) p += way + vector(by / 10);
    return t;
  }

 private:
  Vector3 vector(double size) {
    return size * Vector3(draw_(engine_), draw_(engine_), draw_(engine_));
  }
  std::mt19937_64 engine_;
  std::uniform_real_distribution<double> draw_{-1, 1};
};

/// Expects the distances of a search without a start, of solids `scale` times as large.
void expect_those_of_a_full_search(const Shape& shape, double scale) {
  RandomMotion motion(1);
  int outside = 0, by_feature[3] = {}, tracked_by_feature[3] = {};
  for (int n = 0; n < 2000; ++n) {
    const Triangle before = motion.triangle(0.1 * scale, scale);
    const Triangle now = motion.moved(before, 1e-3 * scale);
    const auto start = face_distance(shape, before, infinity);
    const auto expected = face_distance(shape, now, infinity);
    const auto tracked = tracked_distance(shape, now, start->weights);
    if (expected->value <= 0) {
      EXPECT_FALSE(tracked) << n;
      continue;
    }
    if (start->value <= 0) continue;
    ++outside;
    const auto zeros = std::count(start->weights.begin(), start->weights.end(), 0.0);
    ++by_feature[zeros];
    if (!tracked) continue;
    ++tracked_by_feature[zeros];
    ASSERT_NEAR(tracked->value, expected->value, 1e-9 * scale) << n;
    const Vector3 p = at(now, tracked->weights);
    const Distance there = signed_distance(shape, p, p);
    ASSERT_NEAR(there.value, tracked->value, 1e-12 * scale);
    ASSERT_NEAR((there.normal - tracked->normal).norm(), 0, 1e-12 + 1e-14 * scale / there.value);
    for (const double w : tracked->weights) ASSERT_GE(w, 0);
  }
  EXPECT_GT(outside, 500);
  for (int zeros = 0; zeros < 3; ++zeros) {
    EXPECT_GE(tracked_by_feature[zeros], 0.8 * by_feature[zeros]) << zeros << " zero weights";
  }
}

TEST(TrackedDistance, IsThatOfASearchWithoutAStart) {
  for (const double scale : {1e-3, 1.0, 100.0}) {
    for (const Shape& shape : solids(scale)) {
      SCOPED_TRACE(std::to_string(scale) + ", shape " + std::to_string(shape.index()));
      expect_those_of_a_full_search(shape, scale);
    }
  }
}

TEST(TrackedDistance, AFlushTriangleTouchesTheEdgesOfABox) {
  // All of it is as near as its corner over the box, whose contact would be that of a point.
  const Shape box = Cuboid{{0.4, 0.4, 0.2}};
  for (int side = 0; side < 4; ++side) {
    const Eigen::AngleAxisd turn(side * M_PI / 2, Vector3::UnitZ());
    const Triangle t{turn * Vector3(-0.19, 0, 0.101), turn * Vector3(-0.23, 0.01, 0.101),
                     turn * Vector3(-0.23, -0.02, 0.101)};
    const auto found = face_distance(box, t, 0.01);
    EXPECT_EQ(std::count(found->weights.begin(), found->weights.end(), 0.0), 1) << side;
    EXPECT_FALSE(tracked_distance(box, t, {1, 0, 0})) << side;
    EXPECT_EQ(tracked_distance(box, t, found->weights)->weights, found->weights) << side;
  }
}

TEST(TrackedDistance, IsEmptyBesideShapesThatAreNotConvexOrHaveNoFaces) {
  const Triangle t{Vector3(0, 0, 1), Vector3(0.1, 0, 1), Vector3(0, 0.1, 1)};
  EXPECT_FALSE(tracked_distance(MeshShape{}, t, {1, 0, 0}));
  EXPECT_FALSE(tracked_distance(Plane{}, t, {1, 0, 0}));
}

TEST(TrackedDistance, OfTrianglesWithoutAreaIsFinite) {
  const Vector3 a(0.5, 0.1, 0.2), b(0.6, -0.1, 0.2);
  for (const Shape& shape : solids(1)) {
    for (const Triangle& t : {Triangle{a, a, a}, Triangle{a, b, a}, Triangle{a, b, (a + b) / 2}}) {
      for (const std::array<double, 3>& start :
           {std::array<double, 3>{1, 0, 0}, {0.5, 0.5, 0}, {0.2, 0.3, 0.5}}) {
        const auto tracked = tracked_distance(shape, t, start);
        if (!tracked) continue;
        EXPECT_NEAR(tracked->value, face_distance(shape, t, 10)->value, 1e-9);
        EXPECT_TRUE(tracked->normal.allFinite());
      }
    }
  }
}

}  // namespace
}  // namespace clothsim::tracked_distance_test
