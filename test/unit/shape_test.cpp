#include "clothsim/shapes/shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "clothsim/shapes/signed_distances.h"

namespace clothsim::shape_test {
namespace {

const Shape ball = Sphere{0.5};
const Shape ground = Plane{};
const Shape sheet = Plane{true};
const Shape rod = Capsule{0.8, 0.2};
const Shape crate = Cuboid{{1.2, 0.8, 0.4}};
const Shape drum = Cylinder{0.5, 0.4};
const Shape solids[] = {ball, rod, crate, drum};

/// Points on the surface of a box, so many along each side.
std::vector<Vector3> surface_of(const Cuboid& box, int count) {
  std::vector<Vector3> points;
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i <= count; ++i) {
      for (int j = 0; j <= count; ++j) {
        Vector3 p;
        p[axis] = box.size[axis] / 2;
        p[(axis + 1) % 3] = box.size[(axis + 1) % 3] * (1.0 * i / count - 0.5);
        p[(axis + 2) % 3] = box.size[(axis + 2) % 3] * (1.0 * j / count - 0.5);
        points.push_back(p);
        p[axis] *= -1;
        points.push_back(p);
      }
    }
  }
  return points;
}

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

TEST(Shape, CapsuleDistanceIsThatOfTheNearestBallAlongItsAxis) {
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> draw(-1, 1);
  for (int n = 0; n < 200; ++n) {
    const Vector3 p(draw(engine), draw(engine), draw(engine));
    double nearest = 10;
    for (int i = 0; i <= 20000; ++i) {
      nearest = std::min(nearest, (p - Vector3(0, 0, 0.8 * (i / 20000.0 - 0.5))).norm());
    }
    EXPECT_NEAR(signed_distance(rod, p, p).value, nearest - 0.2, 1e-7);
  }
}

/// Compares distances at random points with those of the nearest of many points of the surface, the
/// farther by up to `tolerance` [m].
template <class Draw, class IsWithin>
void expect_nearest(const Shape& shape, const std::vector<Vector3>& surface, Draw draw,
                    IsWithin is_within, double tolerance) {
  int inside = 0;
  for (int n = 0; n < 200; ++n) {
    const Vector3 p = draw();
    double nearest = 10;
    for (const Vector3& q : surface) nearest = std::min(nearest, (p - q).norm());
    const bool within = is_within(p);
    inside += within;
    const double value = signed_distance(shape, p, p).value;
    EXPECT_EQ(value < 0, within);
    EXPECT_LE(std::abs(value), nearest + 1e-12);
    EXPECT_GT(std::abs(value), nearest - tolerance);
  }
  EXPECT_GT(inside, 10);
}

TEST(Shape, BoxDistanceIsThatOfTheNearestPointOfItsSurface) {
  std::mt19937_64 engine(4);
  std::uniform_real_distribution<double> draw(-1, 1);
  expect_nearest(
      crate, surface_of(std::get<Cuboid>(crate), 120),
      [&] { return Vector3(draw(engine), draw(engine), 0.5 * draw(engine)); },
      [](const Vector3& p) { return (p.cwiseAbs().array() < Eigen::Array3d(0.6, 0.4, 0.2)).all(); },
      0.0075);  // the points are 0.01 m apart
}

TEST(Shape, CylinderDistanceIsThatOfTheNearestPointOfItsSurface) {
  const double length = std::get<Cylinder>(drum).length, radius = std::get<Cylinder>(drum).radius;
  std::vector<Vector3> surface;
  for (int i = 0; i < 400; ++i) {
    const double angle = 2 * M_PI * i / 400;
    const Vector3 out(std::cos(angle), std::sin(angle), 0);
    for (int j = 0; j <= 80; ++j) {
      surface.push_back(radius * out + length * (j / 80.0 - 0.5) * Vector3::UnitZ());
      for (const double end : {-0.5, 0.5}) {
        surface.push_back(j / 80.0 * radius * out + end * length * Vector3::UnitZ());
      }
    }
  }
  std::mt19937_64 engine(6);
  std::uniform_real_distribution<double> draw(-0.7, 0.7);
  expect_nearest(
      drum, surface, [&] { return Vector3(draw(engine), draw(engine), draw(engine)); },
      [&](const Vector3& p) { return p.head<2>().norm() < radius && std::abs(p.z()) < length / 2; },
      0.006);  // the points are 6 mm apart
}

TEST(Shape, DistancesOfManyPointsAreThoseOfEach) {
  // The vector loop against the scalar function, in the frame of a solid that has turned.
  constexpr int count = 203;  // no multiple of a vector's length
  const Points points = Points::Random(count, 3), sides = Points::Random(count, 3);
  const Pose now{{0.1, -0.2, 0.05}, Eigen::Quaterniond(0.8, 0, 0.6, 0)};
  const Pose before{{0, 0.1, 0}, Eigen::Quaterniond(0.6, 0.8, 0, 0)};
  for (const Shape& shape : {ball, ground, sheet, rod, crate, drum}) {
    Scalars distances(count);
    Points normals(count, 3);
    signed_distances(shape, Frame(now), run_from(points, 0), Frame(before), run_from(sides, 0),
                     count, {}, distances.data(), run_from(normals, 0));
    for (int i = 0; i < count; ++i) {
      const Distance one =
          signed_distance(shape, to_local(now, row(points, i)), to_local(before, row(sides, i)));
      EXPECT_NEAR(distances[i], one.value, 1e-15);
      EXPECT_NEAR((row(normals, i) - now.orientation * one.normal).norm(), 0, 2e-15);
    }
    EXPECT_LT(distances.minCoeff(), 0);
    EXPECT_GT(distances.maxCoeff(), 0);
  }
}

TEST(Shape, NormalIsFiniteWhereItIsNotUnique) {
  for (const Vector3& p :
       {Vector3(0, 0, 0), Vector3(0, 0, 0.4), Vector3(0, 0, -0.4), Vector3(0, 0, 0.1),
        Vector3(0.6, 0.4, 0.2), Vector3(-0.6, 0, 0), Vector3(0.6, -0.4, 0), Vector3(0.4, 0.2, 0)}) {
    for (const Shape& shape : solids) {
      const Distance d = signed_distance(shape, p, p);
      EXPECT_TRUE(std::isfinite(d.value));
      EXPECT_NEAR(d.normal.norm(), 1, 1e-15) << p.transpose();
      // The normal leads outwards: a step along it gains its length.
      const Vector3 out = p + 1e-3 * d.normal;
      EXPECT_NEAR(signed_distance(shape, out, out).value - d.value, 1e-3, 1e-12) << p.transpose();
    }
  }
}

TEST(Shape, NormalIsTheGradientOfTheDistance) {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> draw(-1, 1);
  for (const Shape& shape : {ball, ground, sheet, rod, crate, drum}) {
    for (int n = 0; n < 200; ++n) {
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

TEST(Shape, EntryPointIsWhereFineStepsAlongThePathComeWithinTheOffset) {
  std::mt19937_64 engine(5);
  std::uniform_real_distribution<double> draw(-1.5, 1.5);
  const double offset = 0.01;
  for (const Shape& shape : solids) {
    int hits = 0, misses = 0;
    for (int n = 0; n < 1500; ++n) {
      const Vector3 from(draw(engine), draw(engine), draw(engine));
      const Vector3 to(draw(engine), draw(engine), draw(engine));
      const auto entry = entry_point(shape, from, to, offset);
      if (signed_distance(shape, from, from).value < 0) {
        EXPECT_FALSE(entry);
        continue;
      }
      double nearest = 10, first = 2;
      for (int i = 0; i <= 2000; ++i) {
        const double t = i / 2000.0;
        const Vector3 p = from + t * (to - from);
        const double d = signed_distance(shape, p, p).value;
        nearest = std::min(nearest, d);
        if (d <= offset) first = std::min(first, t);
      }
      if (std::abs(nearest - offset) < 0.01) continue;  // it grazes, or meets a grown box's edge
      ASSERT_EQ(entry.has_value(), nearest < offset) << shape.index() << ' ' << n;
      ++(entry ? hits : misses);
      if (!entry) continue;
      const double t = (*entry - from).dot(to - from) / (to - from).squaredNorm();
      EXPECT_NEAR((from + t * (to - from) - *entry).norm(), 0, 1e-12) << "off the path";
      EXPECT_LT(t, first + 1e-12);
      EXPECT_LT(signed_distance(shape, *entry, *entry).value, 1.75 * offset);
      if (signed_distance(shape, from, from).value > offset) {
        EXPECT_GT(signed_distance(shape, *entry, *entry).value, offset - 1e-9);
      }
    }
    EXPECT_GT(hits, 50);
    EXPECT_GT(misses, 50);
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

TEST(Shape, SupportIsAPointOfTheSolidFarthestAlongADirection) {
  const auto expect_support = [](const Shape& shape) {
    for (int n = 0; n < 200; ++n) {
      const Vector3 axis = (n % 2 ? -1 : 1) * Vector3::Unit(n / 2 % 3);
      const Vector3 direction = n < 6 ? axis : Vector3(Vector3::Random().normalized());
      const Vector3 p = support(shape, direction).value(), beyond = p + 0.1 * direction;
      EXPECT_NEAR(signed_distance(shape, p, p).value, 0, 1e-14);
      // The plane through p across the direction has all of the solid below it.
      EXPECT_NEAR(signed_distance(shape, beyond, beyond).value, 0.1, 1e-14) << direction;
    }
  };
  expect_support(Sphere{0.3});
  expect_support(Capsule{0.8, 0.2});
  expect_support(Cuboid{{1.2, 0.8, 0.4}});
  expect_support(Cylinder{0.8, 0.3});
  EXPECT_FALSE(support(Plane{}, Vector3::UnitX()));
  EXPECT_FALSE(support(MeshShape{}, Vector3::UnitX()));
}

TEST(Shape, BoundsHoldTheSolid) {
  EXPECT_EQ(bounding_radius(ball), 0.5);
  EXPECT_TRUE(std::isinf(bounding_radius(ground)));
  EXPECT_NEAR(bounding_radius(rod), 0.6, 1e-15);
  EXPECT_NEAR(bounding_radius(crate), std::sqrt(0.36 + 0.16 + 0.04), 1e-15);
  EXPECT_LE(safe_depth(ball), 0.5);
  EXPECT_LE(safe_depth(rod), 0.2);
  EXPECT_LE(safe_depth(crate), 0.2);
  EXPECT_NEAR(bounding_radius(drum), std::hypot(0.25, 0.4), 1e-15);
  EXPECT_LE(safe_depth(drum), 0.25);
  for (const Shape& shape : solids) EXPECT_GT(safe_depth(shape), 0);
}

TEST(Shape, CornersStandOffByWhatAFlatTriangleDips) {
  // An equilateral triangle that touches a ball with its middle.
  const double edge = 0.06, middle = edge / std::sqrt(3);
  for (const auto& [shape, radius] : {std::pair(ball, 0.5), std::pair(rod, 0.2)}) {
    const double expected = std::hypot(radius + 0.001, middle) - radius;
    EXPECT_NEAR(corner_distance(shape, edge, 0.001), expected, 1e-15);
  }
  EXPECT_EQ(corner_distance(ground, edge, 0.001), 0.001);
  EXPECT_TRUE(std::isinf(corner_distance(crate, edge, 0.001)));
  EXPECT_TRUE(std::isinf(corner_distance(drum, edge, 0.001)));
}

}  // namespace
}  // namespace clothsim::shape_test
