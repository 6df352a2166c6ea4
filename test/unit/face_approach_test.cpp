#include "clothsim/constraints/face_approach.h"

#include <gtest/gtest.h>

#include <random>

namespace clothsim::face_approach_test {
namespace {

TEST(MeasuredTriangle, BoundsTheDistanceOfATriangleThatHasMoved) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto vector = [&](double size) {
    return Vector3(size * Vector3(unit(random), unit(random), unit(random)));
  };
  int near = 0;
  for (const Shape& shape :
       {Shape(Cuboid{{0.3, 0.2, 0.1}}), Shape(Cylinder{0.2, 0.1}), Shape(Sphere{0.1})}) {
    for (int n = 0; n < 2000; ++n) {
      const Vector3 middle = vector(0.3);
      Triangle t{middle + vector(0.05), middle + vector(0.05), middle + vector(0.05)};
      const auto found = face_distance(shape, t, infinity);
      ASSERT_TRUE(found);
      const MeasuredTriangle measured{t, found->value};
      EXPECT_EQ(measured.distance_at(t), found->value);
      Vector3 way = vector(0.03);
      for (Vector3& p : t) p += way + vector(0.002);
      const double now = face_distance(shape, t, infinity)->value;
      const double bound = measured.distance_at(t);
      if (found->value < 0 || now < 0) continue;  // depths are those of the shortest exit
      ASSERT_LE(bound, now + 1e-12);
      near += now - bound < 0.002;
    }
  }
  EXPECT_GT(near, 50) << "the bound is close where the triangle approaches";
  EXPECT_EQ(MeasuredTriangle().distance_at({}), -infinity) << "not measured: it may be anywhere";
}

}  // namespace
}  // namespace clothsim::face_approach_test
