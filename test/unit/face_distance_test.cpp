#include "clothsim/shapes/face_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace clothsim::face_distance_test {
namespace {

const Shape solids[] = {Sphere{0.3},
                        Capsule{0.8, 0.2},
                        Capsule{1.0, 0.01},
                        Cuboid{{1.2, 0.8, 0.4}},
                        Cuboid{{0.8, 0.8, 0.01}},
                        Cylinder{0.8, 0.3},
                        Cylinder{0.02, 0.4},
                        Cylinder{1.2, 0.02}};

Vector3 at(const Triangle& t, const std::array<double, 3>& w) {
  return w[0] * t[0] + w[1] * t[1] + w[2] * t[2];
}

/// Minimum of a convex function on [0, 1].
double min_of(const std::function<double(double)>& f) {
  double low = 0, high = 1;
  for (int i = 0; i < 70; ++i) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    (f(a) < f(b) ? high : low) = f(a) < f(b) ? b : a;
  }
  return f((low + high) / 2);
}

/// Minimum signed distance over the triangle's points, a convex function of them.
double min_over(const Shape& shape, const Triangle& t) {
  return min_of([&](double u) {
    return min_of([&](double v) {
      const Vector3 p = t[0] + u * (t[1] - t[0]) + (1 - u) * v * (t[2] - t[0]);
      return signed_distance(shape, p, p).value;
    });
  });
}

/// Support of the solid along a direction: its farthest extent.
double extent(const Shape& shape, const Vector3& u) {
  if (const auto* s = std::get_if<Sphere>(&shape)) return s->radius;
  if (const auto* c = std::get_if<Capsule>(&shape)) {
    return std::abs(u.z()) * c->length / 2 + c->radius;
  }
  if (const auto* c = std::get_if<Cylinder>(&shape)) {
    return std::abs(u.z()) * c->length / 2 + u.head<2>().norm() * c->radius;
  }
  return u.cwiseAbs().dot(std::get<Cuboid>(shape).size) / 2;
}

/// Length of the shortest translation that separates the triangle from the solid, by random
/// directions.
double shortest_way(const Shape& shape, const Triangle& t, std::mt19937_64& engine) {
  std::normal_distribution<double> draw;
  const auto way = [&](const Vector3& u) {
    return extent(shape, u) - std::min({u.dot(t[0]), u.dot(t[1]), u.dot(t[2])});
  };
  const auto random = [&] { return Vector3(draw(engine), draw(engine), draw(engine)); };
  double shortest = 10;
  for (int start = 0; start < 30; ++start) {
    Vector3 best = random().normalized();
    for (int i = 0; i < 40; ++i) {
      const Vector3 u = random().normalized();
      if (way(u) < way(best)) best = u;
    }
    for (double step = 0.5; step > 1e-7; step *= 0.97) {
      const Vector3 u = (best + step * random()).normalized();
      if (way(u) < way(best)) best = u;
    }
    shortest = std::min(shortest, way(best));
  }
  return shortest;
}

class RandomTriangles {
 public:
  explicit RandomTriangles(std::uint64_t seed) : engine_(seed) {}

  Triangle next() {
    const double size = std::pow(10.0, draw_(engine_) * 0.7 - 0.7);
    const Vector3 middle = 0.8 * point();
    return {middle + size * point(), middle + size * point(), middle + size * point()};
  }

 private:
  Vector3 point() { return {draw_(engine_), draw_(engine_), draw_(engine_)}; }
  std::mt19937_64 engine_;
  std::uniform_real_distribution<double> draw_{-1, 1};
};

TEST(FaceDistance, IsTheLeastDistanceOfTheTrianglesPoints) {
  RandomTriangles triangles(1);
  for (const Shape& shape : solids) {
    int apart = 0;
    for (int n = 0; n < 600; ++n) {
      const Triangle t = triangles.next();
      const double least = min_over(shape, t);
      const auto found = face_distance(shape, t, 10);
      ASSERT_TRUE(found);
      EXPECT_EQ(found->value < 0, least < -1e-9) << shape.index() << ' ' << n;
      if (least <= 1e-9) continue;
      ++apart;
      EXPECT_NEAR(found->value, least, 1e-8);
      // At the reported place, and with the reported normal.
      const auto& w = found->weights;
      EXPECT_NEAR(w[0] + w[1] + w[2], 1, 1e-12);
      for (const double share : w) EXPECT_GE(share, 0);
      const Vector3 p = at(t, w);
      const Distance d = signed_distance(shape, p, p);
      EXPECT_NEAR(d.value, least, 1e-8);
      EXPECT_NEAR((d.normal - found->normal).norm(), 0, 1e-6 + 1e-8 / least);
    }
    EXPECT_GT(apart, 50);
  }
}

TEST(FaceDistance, IsTheShortestWayOutOfTheSolid) {
  RandomTriangles triangles(2);
  std::mt19937_64 engine(3);
  for (const Shape& shape : solids) {
    int crossing = 0;
    for (int n = 0; n < 2000 && crossing < 60; ++n) {
      const Triangle t = triangles.next();
      const auto found = face_distance(shape, t, 10);
      ASSERT_TRUE(found);
      if (found->value >= 0) continue;
      ++crossing;
      const double way = shortest_way(shape, t, engine);
      EXPECT_LT(-found->value, way + 1e-6) << shape.index() << ' ' << n;
      EXPECT_GT(-found->value, 0.97 * way - 1e-4) << shape.index() << ' ' << n;
      // The translation separates them, and a shorter one does not.
      EXPECT_NEAR(found->normal.norm(), 1, 1e-12);
      Triangle out = t, short_of_it = t;
      for (std::size_t i = 0; i < 3; ++i) {
        out[i] -= (found->value - 1e-9) * found->normal;
        short_of_it[i] -= 0.98 * found->value * found->normal;
      }
      EXPECT_GE(face_distance(shape, out, 10)->value, 0);
      EXPECT_LE(face_distance(shape, short_of_it, 10)->value, 0);
    }
    EXPECT_GT(crossing, 10) << shape.index();
  }
}

TEST(FaceDistance, IsEmptyOutOfReach) {
  RandomTriangles triangles(4);
  for (const Shape& shape : solids) {
    int near = 0, far = 0;
    for (int n = 0; n < 2000; ++n) {
      const Triangle t = triangles.next();
      const double value = face_distance(shape, t, 10)->value;
      if (std::abs(value - 0.2) < 1e-9) continue;
      const auto found = face_distance(shape, t, 0.2);
      ASSERT_EQ(found.has_value(), value < 0.2);
      ++(found ? near : far);
      if (found) {
        EXPECT_EQ(found->value, value);
      }
    }
    EXPECT_GT(near, 50);
    EXPECT_GT(far, 50);
  }
  EXPECT_FALSE(face_distance(Plane{}, triangles.next(), 10)) << "its corners tell";
}

TEST(FaceDistance, OfDegenerateTrianglesIsFinite) {
  const Vector3 origin(0, 0, 0), x(0.2, 0, 0), z(0, 0, 0.2), far(3, 3, 3);
  for (const Shape& shape : solids) {
    for (const Triangle& t : {Triangle{origin, origin, origin}, Triangle{origin, x, 2 * x},
                              Triangle{-z, origin, z}, Triangle{-x, x, z}, Triangle{far, far, far},
                              Triangle{-far, origin, far}, Triangle{-10 * x, 10 * x, 100 * z}}) {
      const auto found = face_distance(shape, t, 100);
      ASSERT_TRUE(found);
      EXPECT_TRUE(std::isfinite(found->value));
      EXPECT_NEAR(found->normal.norm(), 1, 1e-12);
      EXPECT_NEAR(found->weights[0] + found->weights[1] + found->weights[2], 1, 1e-12);
      EXPECT_EQ(found->value < 0, min_over(shape, t) < 0);
    }
  }
}

TEST(FaceDistance, ALineThatATriangleLiesOnIsFoundAtTwoOfItsEdges) {
  // Square on a capsule, tilted by a rounding either way; the same for a box's edge below a
  // triangle.
  const Triangle flat{Vector3(-0.3, 0.2, 0.2), Vector3(0.3, 0.2, 0.2), Vector3(0.1, -0.3, 0.2)};
  const Capsule rod{2, 0.1};
  const Cuboid box{{2, 0.4, 0.4}};
  const Eigen::AngleAxisd to_x(M_PI / 2, Vector3::UnitY());  // z to x
  for (const double tilt : {0.0, 1e-9, -1e-9}) {
    Triangle over_rod, over_edge;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3 p = flat[i] + tilt * flat[i].x() * Vector3::UnitZ();
      over_rod[i] = to_x.inverse() * p;
      over_edge[i] = Vector3(p.x(), 0.2, 0.2) +
                     (Vector3(0, 0.1, 0.1) + p.y() * Vector3(0, 1, -1)) / std::sqrt(2.0);
    }
    const auto check = [&](const Shape& shape, const Triangle& t, double distance) {
      const auto nearest = face_distance(shape, t, 1);
      ASSERT_TRUE(nearest);
      EXPECT_NEAR(nearest->value, distance, 1e-8);
      const auto edges = edges_along(shape, t, *nearest, 0.15);
      EXPECT_FALSE(edges[0]) << "the line does not pass below it";
      double lowest = 1, highest = -1;
      for (const std::size_t i : {std::size_t{1}, std::size_t{2}}) {
        ASSERT_TRUE(edges[i]) << i << ' ' << tilt;
        EXPECT_NEAR(edges[i]->value, distance, 1e-8);
        EXPECT_EQ(edges[i]->weights[(i + 2) % 3], 0);
        const double x = at(flat, edges[i]->weights).x();
        lowest = std::min(lowest, x);
        highest = std::max(highest, x);
      }
      // At y = 0 on the sides of the triangle.
      EXPECT_NEAR(lowest, -0.3 + 0.4 * 0.4, 1e-6);
      EXPECT_NEAR(highest, 0.3 - 0.4 * 0.2, 1e-6);
    };
    check(rod, over_rod, 0.1);
    check(box, over_edge, 0.1);
  }
}

TEST(FaceDistance, ACylinderHoldsATriangleOnItsRimItsSideAndItsEnds) {
  const Cylinder drum{0.4, 0.3};
  // An edge square across the rim, no corner near.
  const Vector3 on_rim(0.3, 0, 0.2), out(std::sqrt(0.5), 0, std::sqrt(0.5));
  const Vector3 along(0, 1, 0), down = out.cross(along);
  Triangle t{on_rim + 0.01 * out + down, on_rim + 0.01 * out - down, on_rim + 0.3 * out + along};
  auto found = face_distance(drum, t, 1);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->value, 0.01, 1e-9);
  EXPECT_NEAR((found->normal - out).norm(), 0, 1e-6);
  EXPECT_NEAR((at(t, found->weights) - on_rim - 0.01 * out).norm(), 0, 1e-8);
  // The same depth inside: the same direction.
  for (Vector3& p : t) p -= 0.02 * out;
  found = face_distance(drum, t, 1);
  EXPECT_NEAR(found->value, -0.01, 1e-9);
  EXPECT_NEAR((found->normal - out).norm(), 0, 1e-6);

  // The cylinder reaches through the middle of a triangle whose edges are outside of it.
  const Triangle around{Vector3(-3, -3, 0.19), Vector3(3, -3, 0.19), Vector3(0, 3, 0.19)};
  found = face_distance(drum, around, 1);
  EXPECT_NEAR(found->value, -0.01, 1e-12);
  EXPECT_EQ(found->normal, Vector3::UnitZ());
  // A triangle on an end has contacts where it crosses the end's diameters.
  const Triangle on_end{Vector3(-3, -0.1, 0.21), Vector3(3, -0.1, 0.21), Vector3(0, 3, 0.21)};
  found = face_distance(drum, on_end, 1);
  EXPECT_NEAR(found->value, 0.01, 1e-12);
  const auto edges = edges_along(drum, on_end, *found, 0.1);
  ASSERT_TRUE(edges[0]);
  EXPECT_NEAR(edges[0]->value, 0.01, 1e-12);
  EXPECT_NEAR(at(on_end, edges[0]->weights).x(), 0, 1e-12);
}

TEST(FaceDistance, FacesOfABoxBoundCornersAndItsEdgesEdges) {
  const Cuboid box{{1, 1, 1}};
  // On the middle of a face, one corner lower than the others.
  const Triangle on_top{Vector3(0, 0, 0.6), Vector3(0.1, 0, 0.7), Vector3(0, 0.1, 0.7)};
  EXPECT_EQ(face_distance(box, on_top, 1)->weights, (std::array<double, 3>{1, 0, 0}));
  // Over an edge of the box, no corner near.
  const Triangle over{Vector3(0.8, -0.1, 0.25), Vector3(0.25, -0.1, 0.8), Vector3(0.55, 0.1, 0.55)};
  const auto found = face_distance(box, over, 1);
  EXPECT_NEAR(found->normal.x(), std::sqrt(0.5), 0.05);
  EXPECT_NEAR(found->normal.z(), std::sqrt(0.5), 0.05);
  EXPECT_LT(found->value, 0.04);
}

}  // namespace
}  // namespace clothsim::face_distance_test
