#include "clothsim/constraints/face_approach.h"

#include <gtest/gtest.h>

#include <random>

namespace clothsim::face_approach_test {
namespace {

/// Triangles beside shapes, and after a small motion.
template <class Visit>
void for_triangles_that_move(double size, Visit visit) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto vector = [&](double length) {
    return Vector3(length * Vector3(unit(random), unit(random), unit(random)));
  };
  for (const Shape& shape : {Shape(Cuboid{{0.3, 0.2, 0.1}}), Shape(Cylinder{0.2, 0.1}),
                             Shape(Sphere{0.1}), Shape(Capsule{0.2, 0.05})}) {
    for (int n = 0; n < 2000; ++n) {
      const Vector3 middle = vector(0.3);
      const Triangle t{middle + vector(size), middle + vector(size), middle + vector(size)};
      Triangle moved = t;
      const Vector3 way = vector(0.03);
      for (Vector3& p : moved) p += way + vector(0.002);
      visit(shape, t, moved);
    }
  }
}

TEST(MeasuredTriangle, BoundsTheDistanceOfATriangleThatHasMoved) {
  int near = 0, outside = 0;
  for_triangles_that_move(0.05, [&](const Shape& shape, const Triangle& t, const Triangle& moved) {
    const auto found = face_distance(shape, t, infinity);
    ASSERT_TRUE(found);
    const MeasuredTriangle measured{t, found->value, supporting_plane(shape, t, found)};
    EXPECT_EQ(measured.distance_at(t), found->value);
    const double now = face_distance(shape, moved, infinity)->value;
    const double bound = measured.distance_at(moved);
    if (found->value < 0 || now < 0) return;  // depths are those of the shortest exit
    ASSERT_LE(bound, now + 1e-12);
    ++outside;
    near += now - bound < 0.002;
  });
  EXPECT_GT(near, 0.5 * outside) << "the bound is close, however it moves along the surface";
  EXPECT_EQ(MeasuredTriangle().distance_at({}), -infinity) << "not measured: it may be anywhere";
}

TEST(MeasuredTriangle, OutOfReachIsBoundedByTheTangentsAtItsCorners) {
  int near = 0, outside = 0;
  for_triangles_that_move(0.02, [&](const Shape& shape, const Triangle& t, const Triangle& moved) {
    const double before = face_distance(shape, t, infinity)->value;
    if (before <= 0) return;
    const SupportingPlane plane = supporting_plane(shape, t, {});
    ASSERT_LE(plane.distance_of(t), before);
    ASSERT_LE(plane.distance_of(moved), face_distance(shape, moved, infinity)->value + 1e-12);
    ++outside;
    near += before - plane.distance_of(t) < 0.2 * before;
  });
  EXPECT_GT(near, 0.5 * outside);
}

TEST(MeasuredTriangle, APlaneIsAboveTheSolidWhereATriangleGrazesIt) {
  int grazing = 0;
  for_triangles_that_move(0.05, [&](const Shape& shape, const Triangle& t, const Triangle&) {
    const auto apart = face_distance(shape, t, infinity);
    if (apart->value <= 0) return;
    for (double gap = 1e-13; gap < 1e-5; gap *= 10) {
      Triangle near = t;
      for (Vector3& p : near) p -= (apart->value - gap) * apart->normal;
      const auto found = face_distance(shape, near, infinity);
      const SupportingPlane plane = supporting_plane(shape, near, found);
      if (found->value <= 0) continue;
      ++grazing;
      for (int n = 0; n < 20; ++n) {
        const Vector3 p = support(shape, Vector3::Random().normalized()).value();
        ASSERT_LE(plane.normal.dot(p), plane.support) << gap;
      }
      ASSERT_LE(plane.normal.dot(*support(shape, plane.normal)), plane.support) << gap;
    }
  });
  EXPECT_GT(grazing, 10000);
}

TEST(MeasuredTriangle, HasNoPlaneInASolidOrBesideAMesh) {
  const Triangle t{Vector3(0, 0, 0), Vector3(0.01, 0, 0), Vector3(0, 0.01, 0)};
  const Shape ball = Sphere{0.1};
  EXPECT_EQ(supporting_plane(ball, t, face_distance(ball, t, 1)).distance_of(t), -infinity);
  EXPECT_EQ(supporting_plane(MeshShape{}, t, {}).distance_of(t), -infinity);
}

/// A cloth of three points, of which the first is held.
Cloth held_at_one() {
  Cloth cloth;
  cloth.offset = 0.002;
  cloth.inv_mass = Vector3(0, 1, 1);
  return cloth;
}

TEST(RaisedAtHeld, AHeldCornerCountsAsOffTheSurface) {
  const Cloth cloth = held_at_one();
  const Shape box = Cuboid{{1, 1, 1}};  // its top is at 0.5
  for (const double gap : {-0.00005, 0.0005, 0.002, 0.0025, 0.01}) {
    const Triangle t{Vector3(0, 0, 0.5 + gap), Vector3(0.1, 0, 0.501), Vector3(0, 0.05, 0.501)};
    const Triangle raised = raised_at_held(box, cloth, {0, 1, 2}, t);
    const double longest = (t[2] - t[1]).norm();
    EXPECT_NEAR(raised[0].z(), 0.5 + std::max(gap, 0.002 + 0.01 * longest), 1e-15);
    EXPECT_EQ(raised[0].head<2>(), t[0].head<2>());
    EXPECT_EQ(raised[1], t[1]);
    EXPECT_EQ(raised[2], t[2]);
    const Triangle same = raised_at_held(box, cloth, {1, 1, 2}, t);
    EXPECT_EQ(same[0], t[0]) << "no corner is held";
  }
}

TEST(RaisedAtHeld, TheGapsDerivativeIsThatOfTheWeights) {
  // Otherwise an impulse that closes a gap takes the triangle into the solid.
  const Cloth cloth = held_at_one();
  int between = 0;
  for (const Shape& shape :
       {Shape(Capsule{0.4, 0.06}), Shape(Cylinder{0.4, 0.06}), Shape(Cuboid{{0.12, 0.12, 0.4}})}) {
    for (const double gap : {0.0003, 0.001, 0.002, 0.003}) {
      for (double height = 0.055; height < 0.064; height += 0.0005) {
        const Triangle t{Vector3(0.06 + gap, 0, 0), Vector3(height, 0.017, 0),
                         Vector3(height, 0.017, 0.017)};
        const auto distance_at = [&](double lift) {
          Triangle lifted = t;
          for (std::size_t k : {1, 2}) lifted[k].x() += lift;
          return *face_distance(shape, raised_at_held(shape, cloth, {0, 1, 2}, lifted), infinity);
        };
        const double step = 1e-7;
        const FaceDistance now = distance_at(0);
        const double free = now.weights[1] + now.weights[2];
        const bool touches = now.value > 0 && now.value < cloth.offset;
        if (!touches || free == 0 || free == 1) continue;
        ++between;
        const double rate = (distance_at(step).value - distance_at(-step).value) / (2 * step);
        EXPECT_NEAR(rate, free * now.normal.x(), 0.02) << gap << ' ' << height;
        EXPECT_GT(free, 0.1) << "the free corners move at most ten times as far as the gap changes";
      }
    }
  }
  EXPECT_GT(between, 20);
}

}  // namespace
}  // namespace clothsim::face_approach_test
