#include "clothsim/collision/shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace clothsim {
namespace {

const Shape ball = Sphere{0.5};
const Shape ground = Plane{};
const Shape sheet = Plane{true};

TEST(Shape, SphereDistance) {
  const Vector3 p(0.6, 0, 0.8);
  EXPECT_NEAR(signed_distance(ball, p, p).value, 0.5, 1e-15);
  EXPECT_NEAR((signed_distance(ball, p, p).normal - p).norm(), 0, 1e-15);
  EXPECT_NEAR(signed_distance(ball, 0.1 * p, p).value, -0.4, 1e-15);
  const Distance centre = signed_distance(ball, Vector3::Zero(), p);
  EXPECT_EQ(centre.value, -0.5);
  EXPECT_EQ(centre.normal, Vector3::UnitZ());
}

TEST(Shape, PlaneIsSolidBelow) {
  const Vector3 up(3, 4, 0.2);
  const Vector3 down(3, 4, -0.2);
  EXPECT_EQ(signed_distance(ground, up, down).value, 0.2);
  EXPECT_EQ(signed_distance(ground, down, down).value, -0.2);
  EXPECT_EQ(signed_distance(ground, down, down).normal, Vector3::UnitZ());
}

TEST(Shape, TwoSidedPlaneIsSolidBeyondWhereThePointCameFrom) {
  const Vector3 up(3, 4, 0.2);
  const Vector3 down(3, 4, -0.2);
  EXPECT_EQ(signed_distance(sheet, up, up).value, 0.2);
  EXPECT_EQ(signed_distance(sheet, down, up).value, -0.2);
  EXPECT_EQ(signed_distance(sheet, down, down).value, 0.2);
  EXPECT_EQ(signed_distance(sheet, up, down).value, -0.2);
  EXPECT_EQ(signed_distance(sheet, up, down).normal, -Vector3::UnitZ());
}

TEST(Shape, NormalIsTheGradientOfTheDistance) {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> draw(-1, 1);
  for (const Shape& shape : {ball, ground, sheet}) {
    for (int n = 0; n < 50; ++n) {
      const Vector3 p(draw(engine), draw(engine), draw(engine));
      const Distance d = signed_distance(shape, p, p);
      EXPECT_NEAR(d.normal.norm(), 1, 1e-14);
      for (int axis = 0; axis < 3; ++axis) {
        const Vector3 step = 1e-6 * Vector3::Unit(axis);
        const double slope = (signed_distance(shape, p + step, p).value -
                              signed_distance(shape, p - step, p).value) /
                             2e-6;
        EXPECT_NEAR(d.normal[axis], slope, 1e-8);
      }
    }
  }
}

TEST(Shape, EntryPointIsWhereThePathFirstMeetsTheSphere) {
  // Against fine steps along the path, for random paths.
  std::mt19937_64 engine(2);
  std::uniform_real_distribution<double> draw(-1.5, 1.5);
  const double offset = 0.01;
  int hits = 0;
  for (int n = 0; n < 500; ++n) {
    const Vector3 from(draw(engine), draw(engine), draw(engine));
    const Vector3 to(draw(engine), draw(engine), draw(engine));
    const auto entry = entry_point(ball, from, to, offset);
    if (from.norm() < 0.5) {
      EXPECT_FALSE(entry) << "it started in the solid";
      continue;
    }
    // Closest approach of the segment to the centre.
    const Vector3 d = to - from;
    const double t = std::clamp(-from.dot(d) / d.squaredNorm(), 0.0, 1.0);
    const double nearest = (from + t * d).norm();
    ASSERT_EQ(entry.has_value(), nearest < 0.51) << n;
    if (!entry) continue;
    ++hits;
    EXPECT_NEAR(entry->norm(), 0.51, 1e-12);
    EXPECT_LT((*entry - from).dot(d) / d.squaredNorm(), t + 1e-12) << "the far side";
    EXPECT_NEAR((*entry - from).cross(d).norm(), 0, 1e-12) << "off the path";
  }
  EXPECT_GT(hits, 50);
}

TEST(Shape, EntryPointOfDegeneratePaths) {
  const Vector3 outside(1, 0, 0);
  EXPECT_FALSE(entry_point(ball, outside, outside, 0.01));
  EXPECT_FALSE(entry_point(ball, outside, 2 * outside, 0.01)) << "it moves away";
  EXPECT_FALSE(entry_point(ball, Vector3(-1, 0.51, 0), Vector3(1, 0.51 + 1e-9, 0), 0.01));
  const auto through = entry_point(ball, 1e3 * outside, -1e3 * outside, 0.01);
  ASSERT_TRUE(through);
  EXPECT_NEAR(through->x(), 0.51, 1e-9);
  const Vector3 touching(0.505, 0, 0);
  EXPECT_EQ(*entry_point(ball, touching, -touching, 0.01), touching);
  EXPECT_FALSE(entry_point(ball, touching, 2 * touching, 0.01));
  EXPECT_FALSE(entry_point(ground, Vector3(0, 0, 1), Vector3(0, 0, -1), 0.01));
}

TEST(Shape, BoundsHoldTheSolid) {
  EXPECT_EQ(bounding_radius(ball), 0.5);
  EXPECT_TRUE(std::isinf(bounding_radius(ground)));
  EXPECT_LE(safe_depth(ball), 0.5);
  EXPECT_GT(safe_depth(ball), 0);
}

}  // namespace
}  // namespace clothsim
