#include "clothsim/shapes/solid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "clothsim/geometry/closest_points.h"
#include "clothsim/model/errors.h"
#include "clothsim/shapes/face_distance.h"
#include "meshes.h"

namespace clothsim::solid_test {
namespace {

using namespace test;

Triangle triangle_of(const TriangleSoup& soup, std::size_t t) {
  const auto at = [&](int i) { return soup.vertices[static_cast<std::size_t>(i)]; };
  return {at(soup.triangles[t][0]), at(soup.triangles[t][1]), at(soup.triangles[t][2])};
}

/// Whether the surface encloses the point, by the sum of the solid angles of its triangles (van
/// Oosterom & Strackee 1983).
bool is_within(const TriangleSoup& soup, const Vector3& p) {
  double sum = 0;
  for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
    Triangle t = triangle_of(soup, i);
    for (Vector3& corner : t) corner -= p;
    const double a = t[0].norm(), b = t[1].norm(), c = t[2].norm();
    sum += 2 * std::atan2(t[0].dot(t[1].cross(t[2])),
                          a * b * c + t[0].dot(t[1]) * c + t[1].dot(t[2]) * a + t[2].dot(t[0]) * b);
  }
  return std::abs(sum) > 2 * M_PI;
}

/// Signed distance by a check of all triangles.
double by_all(const TriangleSoup& soup, const Vector3& p) {
  double least = 1e9;
  for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
    const Triangle t = triangle_of(soup, i);
    const auto w = closest_on_triangle(p, t[0], t[1], t[2]);
    least = std::min(least, (w[0] * t[0] + w[1] * t[1] + w[2] * t[2] - p).norm());
  }
  return is_within(soup, p) ? -least : least;
}

const TriangleSoup soups[] = {
    box_soup({0.3, 0.2, 0.004}),
    turned(step_soup(0.2), Eigen::Quaterniond(0.8, 0.2, 0.4, 0.4)),
    torus_soup(0.1, 0.03, 24, 12),
    ball_soup(0.1, 24, 12),
    finger_soup(),
};

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double operator()(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  Vector3 vector() { return {(*this)(-1, 1), (*this)(-1, 1), (*this)(-1, 1)}; }

  /// Anywhere about it, at or near the surface, or at a corner.
  Vector3 near(const TriangleSoup& soup, const Solid& solid) {
    if ((*this)(0, 1) < 0.3) return 1.5 * solid.radius() * vector();
    const auto n = static_cast<double>(soup.triangles.size());
    const Triangle t = triangle_of(soup, static_cast<std::size_t>((*this)(0, n)));
    if ((*this)(0, 1) < 0.2) return t[0] + 1e-3 * solid.radius() * vector();
    const double u = (*this)(0, 1), v = (*this)(0, 1 - u);
    const Vector3 on = t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
    return on + std::pow(10, (*this)(-5, -1)) * solid.radius() * vector();
  }

 private:
  std::mt19937_64 engine_;
};

TEST(Solid, DistanceIsThatOfTheNearestOfAllTriangles) {
  Random random(1);
  for (const TriangleSoup& soup : soups) {
    const Solid solid(soup);
    int inside = 0;
    for (int n = 0; n < 2000; ++n) {
      const Vector3 p = random.near(soup, solid);
      const auto [value, normal] = solid.distance(p);
      ASSERT_NEAR(value, by_all(soup, p), 1e-12) << n;
      ASSERT_NEAR(normal.norm(), 1, 1e-12);
      inside += value < 0;
      // The nearest point of the surface lies along the normal.
      ASSERT_NEAR(by_all(soup, p - value * normal), 0, 1e-9) << n;
    }
    EXPECT_GT(inside, 100);
  }
}

TEST(Solid, DistanceWithinIsExactNearAndInsideAndNotMoreAfar) {
  Random random(7);
  for (const TriangleSoup& soup : soups) {
    const Solid solid(soup);
    for (const double share : {1e-4, 0.01, 0.1, 3.0}) {
      const double near = share * solid.radius();
      int beyond = 0, inside = 0;
      for (int n = 0; n < 2000; ++n) {
        const Vector3 p = random.near(soup, solid);
        const auto [value, normal] = solid.distance(p);
        Solid::Neighbourhood none;
        const auto [within, about] = solid.distance_within(near, p, none);
        EXPECT_NEAR(about.norm(), 1, 1e-12);
        inside += value < 0;
        if (value < near) {
          EXPECT_EQ(within, value);
          EXPECT_EQ(about, normal);
        } else {
          ++beyond;
          EXPECT_GE(within, near);
          EXPECT_LE(within, value + 1e-12);
        }
      }
      EXPECT_GT(inside, 100);
      if (share < 1) {
        EXPECT_GT(beyond, 100);
      }
    }
  }
}

TEST(Solid, DistanceWithinIsTheSameWhereverOnesWayCameFrom) {
  Random random(8);
  for (const TriangleSoup& soup : soups) {
    const Solid solid(soup);
    const double near = 0.1 * solid.radius();
    Solid::Neighbourhood kept;
    Vector3 p = random.near(soup, solid);
    int beside = 0;
    for (int n = 0; n < 20000; ++n) {
      // Mostly small steps, now and then another place.
      p += std::pow(10, random(-7, -2)) * solid.radius() * random.vector();
      if (random(0, 1) < 0.02) p = random.near(soup, solid);
      const auto [value, normal] = solid.distance(p);
      const Solid::Neighbourhood before = kept;
      const auto [within, about] = solid.distance_within(near, p, kept);
      beside += before.count > 0 && kept.place == before.place;
      if (value < near) {
        ASSERT_EQ(within, value) << n;
        ASSERT_EQ(about, normal) << n;
      } else {
        ASSERT_GE(within, near) << n;
        ASSERT_LE(within, value + 1e-12) << n;
      }
    }
    EXPECT_GT(beside, 2000) << "what was kept was of use";
  }
}

TEST(Solid, NormalIsTheGradientAndTakesPointsOnTheSurfaceOut) {
  Random random(2);
  for (const TriangleSoup& soup : soups) {
    const Solid solid(soup);
    int smooth = 0;
    for (int n = 0; n < 500; ++n) {
      const Vector3 p = random.near(soup, solid);
      const auto [value, normal] = solid.distance(p);
      Vector3 slope;
      for (int axis = 0; axis < 3; ++axis) {
        const Vector3 step = 1e-7 * Vector3::Unit(axis);
        slope[axis] = (solid.distance(p + step).first - solid.distance(p - step).first) / 2e-7;
      }
      if (std::abs(slope.norm() - 1) > 1e-3) continue;  // between two nearest points
      ++smooth;
      EXPECT_NEAR((slope - normal).norm(), 0, 0.05) << value;
    }
    EXPECT_GT(smooth, 300);
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
      const Triangle t = triangle_of(soup, i);
      if ((t[1] - t[0]).cross(t[2] - t[0]).isZero(1e-12)) continue;  // at a pole
      const Vector3 p = (t[0] + t[1] + t[2]) / 3;
      const auto [value, normal] = solid.distance(p);
      EXPECT_NEAR(value, 0, 1e-15);
      EXPECT_GT(solid.distance(p + 1e-6 * normal).first, 0);
      EXPECT_LT(solid.distance(p - 1e-6 * normal).first, 0);
    }
  }
}

TEST(Solid, TellsHowThickItIs) {
  EXPECT_NEAR(Solid(soups[0]).thickness(), 0.004, 1e-9);
  EXPECT_NEAR(Solid(ball_soup(0.1, 48, 24)).thickness(), 0.2, 0.01);
  EXPECT_NEAR(Solid(finger_soup()).thickness(), 0.016, 0.004);
}

TEST(Solid, ASmoothOneTellsHowDeepAFlatTriangleDips) {
  // A fine ball has the dip of a sphere. A ridge has a dip of its own.
  const double edge = 0.06, of_ball = edge * edge / 6 / 0.2;
  EXPECT_NEAR(Solid(ball_soup(0.2, 200, 100)).dip(edge), of_ball, 0.04 * of_ball);
  EXPECT_NEAR(Solid(globe_soup(0.2, 30)).dip(edge), of_ball, 0.04 * of_ball);
  EXPECT_NEAR(Solid(box_soup({1, 1, 1})).dip(edge), edge / 4 * M_PI / 2, 1e-12);
}

TEST(Solid, AnInsideOutOneIsTurned) {
  TriangleSoup soup = step_soup(0.2);
  for (auto& [a, b, c] : soup.triangles) std::swap(b, c);
  EXPECT_LT(Solid(soup).distance({-0.05, 0, -0.05}).first, 0);
}

TEST(Solid, RefusesWhatIsNone) {
  const auto refusal = [](const std::function<void(TriangleSoup&)>& spoil) {
    TriangleSoup soup = box_soup({1, 1, 1});
    spoil(soup);
    try {
      Solid solid(soup);
    } catch (const InvalidValue& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const auto expect = [&](const std::string& words, const auto& spoil) {
    EXPECT_NE(refusal(spoil).find(words), std::string::npos) << refusal(spoil);
  };
  EXPECT_EQ(refusal([](TriangleSoup&) {}), "accepted");
  expect("a hole at the edge from", [](TriangleSoup& s) { s.triangles.pop_back(); });
  expect("opposite sense",
         [](TriangleSoup& s) { std::swap(s.triangles[0][0], s.triangles[0][1]); });
  expect("more than two triangles", [](TriangleSoup& s) { s.triangles.push_back(s.triangles[0]); });
  expect("not finite", [](TriangleSoup& s) { s.vertices[3].y() = NAN; });
  expect("no triangles", [](TriangleSoup& s) { s.triangles.clear(); });
  expect("no triangles", [](TriangleSoup& s) {
    for (Vector3& p : s.vertices) p.setZero();
  });
  expect("without a volume", [](TriangleSoup& s) {
    for (Vector3& p : s.vertices) p.z() = 0.1 * p.x();
  });
}

/// A small triangle about the solid's surface.
Triangle random_triangle(Random& random, const TriangleSoup& soup, const Solid& solid) {
  const double size = solid.radius() * std::pow(10, random(-1.5, 0));
  const Vector3 middle = random.near(soup, solid);
  return {middle + size * random.vector(), middle + size * random.vector(),
          middle + size * random.vector()};
}

/// Whether the triangles share a point, and their distance [m].
std::pair<bool, double> apart(const Triangle& s, const Triangle& t) {
  bool cross = triangles_cross(s, t);
  double least = 1e9;
  const auto add = [&](const Vector3& a, const Vector3& b) {
    least = std::min(least, (a - b).norm());
  };
  for (const auto& [one, other] : {std::pair(s, t), std::pair(t, s)}) {
    for (const Vector3& p : one) {
      const auto w = closest_on_triangle(p, other[0], other[1], other[2]);
      add(p, w[0] * other[0] + w[1] * other[1] + w[2] * other[2]);
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3 u = s[(i + 1) % 3] - s[i], v = t[(k + 1) % 3] - t[k];
      const auto where = closest_on_segments(s[i], s[i] + u, t[k], t[k] + v);
      add(s[i] + where.s * u, t[k] + where.t * v);
    }
  }
  return {cross, least};
}

TEST(Solid, FaceDistanceIsThatOfAllPairsOfTriangles) {
  Random random(3);
  for (const TriangleSoup& soup : soups) {
    const Shape shape = mesh_shape(soup);
    const Solid& solid = std::get<MeshShape>(shape).file->solid;
    int outside = 0, inside = 0;
    for (int n = 0; n < 1500; ++n) {
      const Triangle t = random_triangle(random, soup, solid);
      bool crosses = false;
      double least = 1e9;
      for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        const auto [cross, away] = apart(triangle_of(soup, i), t);
        crosses = crosses || cross;
        least = std::min(least, away);
      }
      const auto found = face_distance(shape, t, 10);
      ASSERT_TRUE(found);
      EXPECT_NEAR(found->normal.norm(), 1, 1e-12);
      EXPECT_NEAR(found->weights[0] + found->weights[1] + found->weights[2], 1, 1e-12);
      if (crosses || is_within(soup, t[0])) {
        ++inside;
        EXPECT_LT(found->value, 0) << n << ' ' << crosses;
        continue;
      }
      ++outside;
      ASSERT_NEAR(found->value, least, 1e-12) << n;
      const Vector3 p =
          found->weights[0] * t[0] + found->weights[1] * t[1] + found->weights[2] * t[2];
      const Distance there = signed_distance(shape, p, p);
      EXPECT_NEAR(there.value, least, 1e-12);
      EXPECT_NEAR((there.normal - found->normal).norm(), 0, 1e-6 + 1e-13 / least);
      // Within reach or not.
      EXPECT_FALSE(face_distance(shape, t, 0.99 * least));
      EXPECT_EQ(face_distance(shape, t, 1.01 * least)->value, found->value);
    }
    EXPECT_GT(outside, 300);
    EXPECT_GT(inside, 100);
  }
}

TEST(Solid, FaceDistanceIsTheSameWhereverOnesWayCameFrom) {
  Random random(9);
  std::vector<Shape> shapes;
  for (const TriangleSoup& soup : soups) shapes.push_back(mesh_shape(soup, 0.002));
  shapes.push_back(sheet_shape(above_z(globe_soup(0.1, 5), 0.02), 0.004));
  for (const Shape& shape : shapes) {
    const Solid& solid = std::get<MeshShape>(shape).file->solid;
    const TriangleSoup soup{solid.vertices(), solid.triangles()};
    Solid::Surroundings kept;
    std::array<Solid::Neighbourhood, 3> corners;
    const FaceQuery query{&kept, {&corners[0], &corners[1], &corners[2]}};
    Triangle t = random_triangle(random, soup, solid);
    int within = 0, inside = 0, beside = 0;
    for (int n = 0; n < 10000; ++n) {
      // Mostly small steps, now and then another place.
      for (Vector3& p : t) p += std::pow(10, random(-7, -2)) * solid.radius() * random.vector();
      if (random(0, 1) < 0.02) t = random_triangle(random, soup, solid);
      const double reach = random(0, 1) < 0.2 ? 0 : std::pow(10, random(-3, 0)) * solid.radius();
      const Solid::Surroundings before = kept;
      const auto expected = face_distance(shape, t, reach),
                 found = face_distance(shape, t, reach, query);
      ASSERT_EQ(found.has_value(), expected.has_value()) << n;
      if (found) {
        ASSERT_EQ(found->value, expected->value) << n;
        ASSERT_EQ(found->normal, expected->normal) << n;
        ASSERT_EQ(found->weights, expected->weights) << n;
        ++within;
        inside += found->value < 0;
      }
      beside += before.cover(t, 0) && kept.place == before.place;
      ASSERT_EQ(touches_between_corners(shape, t, reach, query),
                touches_between_corners(shape, t, reach));
    }
    EXPECT_GT(within, 3000);
    EXPECT_GT(inside, 300);
    EXPECT_GT(beside, 1000) << "what was kept was of use";
  }
}

TEST(Solid, ABoxOfTrianglesIsABox) {
  const Vector3 size(0.3, 0.2, 0.1);
  const Shape mesh = mesh_shape(box_soup(size)), box = Cuboid{size};
  Random random(4);
  int cut = 0;
  for (int n = 0; n < 5000; ++n) {
    const Vector3 p = 0.3 * random.vector();
    EXPECT_NEAR(signed_distance(mesh, p, p).value, signed_distance(box, p, p).value, 1e-14);
    Triangle t;
    const Vector3 middle = 0.25 * random.vector();
    for (Vector3& corner : t) corner = middle + 0.05 * random.vector();
    const double of_mesh = face_distance(mesh, t, 1)->value;
    const double of_box = face_distance(box, t, 1)->value;
    if (of_box > 0) {
      EXPECT_NEAR(of_mesh, of_box, 1e-12);
    } else {
      EXPECT_LT(of_mesh, 0);
      // Where it cuts off at most an edge, the way out is the same.
      cut += std::abs(of_mesh - of_box) < 1e-9;
    }
  }
  EXPECT_GT(cut, 100);
}

/// A fine prism about the axis lies in the cylinder, within the sagitta of its chords.
TEST(Solid, ACylinderIsAsFarAwayAsItsTriangles) {
  constexpr double length = 0.3, radius = 0.1;
  constexpr int around = 720;
  const double dip = radius * (1 - std::cos(M_PI / around));  // 1 um
  const Solid solid(turned_soup(
      around, 3, [=](double v) { return std::pair(radius, v < 0.5 ? -length / 2 : length / 2); }));
  const Shape cylinder = Cylinder{length, radius};
  Random random(11);
  int inside = 0;
  for (int n = 0; n < 10'000; ++n) {
    const Vector3 vector = random.vector(), axis = random.vector();
    const Pose pose{vector, Eigen::Quaterniond(Eigen::AngleAxisd(axis.norm(), axis.normalized()))};
    const Vector3 there = vector + 0.2 * random.vector(), p = to_local(pose, there);
    const double value = signed_distance(cylinder, p, p).value, of_mesh = solid.distance(p).first;
    inside += value < 0;
    ASSERT_GE(of_mesh, value - 1e-12) << n;
    ASSERT_LE(of_mesh, value + dip + 1e-12) << n;
  }
  EXPECT_GT(inside, 500);
}

TEST(Solid, PaddingIsADistanceLess) {
  Random random(5);
  const Shape thin = mesh_shape(soups[1]), padded = mesh_shape(soups[1], 0.005);
  for (int n = 0; n < 300; ++n) {
    const Triangle t = random_triangle(random, soups[1], std::get<MeshShape>(thin).file->solid);
    const Vector3& p = t[0];
    EXPECT_EQ(signed_distance(padded, p, p).value, signed_distance(thin, p, p).value - 0.005);
    EXPECT_EQ(face_distance(padded, t, 1)->value, face_distance(thin, t, 1)->value - 0.005);
  }
  EXPECT_EQ(bounding_radius(padded), bounding_radius(thin) + 0.005);
}

TEST(Solid, EntryIsWhereAPathFirstComesWithinTheOffsetAlsoPastAHollow) {
  Random random(6);
  for (const TriangleSoup& soup : {soups[1], soups[2]}) {
    const Shape shape = mesh_shape(soup);
    int hits = 0, misses = 0;
    const double offset = 0.001;
    for (int n = 0; n < 400; ++n) {
      const Vector3 from = 0.25 * random.vector(), to = 0.25 * random.vector();
      if (signed_distance(shape, from, from).value < offset) continue;
      const auto entry = entry_point(shape, from, to, offset);
      double first = 2, nearest = 1;
      for (int i = 0; i <= 1000; ++i) {
        const Vector3 p = from + i / 1000.0 * (to - from);
        const double value = signed_distance(shape, p, p).value;
        nearest = std::min(nearest, value);
        if (value <= offset) first = std::min(first, i / 1000.0);
      }
      if (std::abs(nearest - offset) < 1e-3) continue;  // it grazes
      ASSERT_EQ(entry.has_value(), nearest < offset) << n;
      ++(entry ? hits : misses);
      if (!entry) continue;
      const double value = signed_distance(shape, *entry, *entry).value;
      // Past an edge that it grazes it goes in steps of half the offset.
      EXPECT_GT(value, 0.4 * offset);
      EXPECT_LT(value, 1.06 * offset);
      EXPECT_LT((*entry - from).norm(), (first + 1e-3) * (to - from).norm() + offset / 2);
    }
    EXPECT_GT(hits, 50);
    EXPECT_GT(misses, 50);
  }
}

}  // namespace
}  // namespace clothsim::solid_test
