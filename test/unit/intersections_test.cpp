// Triangles that cross: the definition, against an exact oracle in integers; and pairs in a mesh,
// against a check of all pairs.

#include "clothsim/geometry/intersections.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <utility>

#include "clothsim/geometry/orientation.h"
#include "clothsim/model/grid.h"

namespace clothsim::intersections_test {
namespace {

// ---- One pair -----------------------------------------------------------------------------------

/// The same answer for either order of the triangles and any first corners.
bool cross_in_every_order(const Triangle& s, const Triangle& t) {
  const bool answer = triangles_cross(s, t);
  std::array<std::size_t, 3> order{0, 1, 2};
  do {
    const Triangle u{s[order[0]], s[order[1]], s[order[2]]};
    const Triangle v{t[order[2]], t[order[0]], t[order[1]]};
    EXPECT_EQ(triangles_cross(u, t), answer);
    EXPECT_EQ(triangles_cross(s, v), answer);
    EXPECT_EQ(triangles_cross(v, u), answer);
  } while (std::next_permutation(order.begin(), order.end()));
  return answer;
}

TEST(TrianglesCross, TouchingIsNotCrossing) {
  const Triangle floor{Vector3(0, 0, 0), Vector3(4, 0, 0), Vector3(0, 4, 0)};
  const struct {
    const char* name;
    Triangle triangle;
    bool crosses;
  } cases[] = {
      {"an edge through the middle", {{{1, 1, -1}, {1, 1, 1}, {9, 9, 0}}}, true},
      {"a corner through the middle", {{{1, 1, -1}, {0, 1, 5}, {1, 0, 5}}}, true},
      {"across an edge of each", {{{1, -1, 0}, {1, 1, -1}, {1, 1, 1}}}, true},
      {"an edge through a corner, going on inside", {{{0, 0, -1}, {0, 0, 1}, {1, 1, 0}}}, true},
      {"an edge through an edge, going on inside", {{{1, 0, -1}, {1, 0, 1}, {1, 1, 0}}}, true},
      {"the same cut in both", {{{0, 0, -1}, {0, 0, 1}, {8, 8, 0}}}, true},
      {"apart", {{{1, 1, 1}, {2, 1, 2}, {1, 2, 3}}}, false},
      {"its plane only", {{{5, 5, -1}, {5, 5, 1}, {9, 9, 0}}}, false},
      {"a corner on the inside", {{{1, 1, 0}, {2, 1, 2}, {1, 2, 3}}}, false},
      {"a corner on an edge", {{{1, 0, 0}, {2, 1, 2}, {1, 2, 3}}}, false},
      {"a corner on a corner", {{{0, 0, 0}, {2, 1, 2}, {1, 2, 3}}}, false},
      {"an edge on the inside", {{{1, 1, 0}, {2, 1, 0}, {1, 2, 3}}}, false},
      {"an edge across in the plane", {{{-1, 1, 0}, {9, 1, 0}, {1, 2, 3}}}, false},
      {"an edge on an edge", {{{0, 0, 0}, {4, 0, 0}, {1, 2, 3}}}, false},
      {"an edge on an edge, to both sides", {{{-1, 0, 0}, {2, -2, 1}, {9, 0, 0}}}, false},
      {"an edge through an edge, going off", {{{1, 0, -1}, {1, 0, 1}, {1, -5, 0}}}, false},
      {"an edge through a corner, going off", {{{0, 0, -1}, {0, 0, 1}, {-1, -1, 0}}}, false},
      {"the same triangle", floor, false},
      {"overlapping in the plane", {{{1, 1, 0}, {5, 1, 0}, {1, 5, 0}}}, false},
      {"a needle through the middle", {{{1, 1, -1}, {1, 1, 1}, {1, 1, 3}}}, false},
      {"a needle without thickness", {{{1, 1, -1}, {1, 1, 1}, {1, 1, 1}}}, false},
      {"a point in the middle", {{{1, 1, 0}, {1, 1, 0}, {1, 1, 0}}}, false},
  };
  for (const auto& c : cases)
    EXPECT_EQ(cross_in_every_order(floor, c.triangle), c.crosses) << c.name;
}

using Integers = std::array<std::int64_t, 3>;

Integers minus(const Integers& p, const Integers& q) {
  return {p[0] - q[0], p[1] - q[1], p[2] - q[2]};
}
std::int64_t dot(const Integers& p, const Integers& q) {
  return p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
}
Integers cross(const Integers& p, const Integers& q) {
  return {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
}

/// Moller's interval test in exact integers and fractions (1997, "A fast triangle-triangle
/// intersection test"), strict: the open triangles share a stretch of the line where their planes
/// meet.
class Oracle {
 public:
  using IntegerTriangle = std::array<Integers, 3>;

  static bool cross(const IntegerTriangle& s, const IntegerTriangle& t) {
    const Integers n = normal(s), m = normal(t);
    const Integers line = intersections_test::cross(n, m);
    const auto [s_begin, s_end, s_cut] = cut(s, t[0], m, line);
    const auto [t_begin, t_end, t_cut] = cut(t, s[0], n, line);
    return s_cut && t_cut && s_begin < t_end && t_begin < s_end;
  }

 private:
  struct Fraction {
    std::int64_t top;
    std::int64_t bottom;  // > 0
    bool operator<(const Fraction& other) const { return top * other.bottom < other.top * bottom; }
  };
  struct Interval {
    Fraction begin{0, 1};
    Fraction end{0, 1};
    bool cut = false;  // the plane separates the triangle's corners
  };

  static Integers normal(const IntegerTriangle& t) {
    return intersections_test::cross(minus(t[1], t[0]), minus(t[2], t[0]));
  }

  static Interval cut(const IntegerTriangle& t, const Integers& origin, const Integers& plane,
                      const Integers& line) {
    std::array<std::int64_t, 3> heights;
    for (std::size_t i = 0; i < 3; ++i) heights[i] = dot(plane, minus(t[i], origin));
    Interval interval;
    const auto [least, most] = std::minmax({heights[0], heights[1], heights[2]});
    if (least >= 0 || most <= 0) return interval;

    bool first = true;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        // From the height of i, not below, down to that of j, below.
        if (heights[i] < 0 || heights[j] >= 0) {
          continue;
        }
        const std::int64_t bottom = heights[i] - heights[j];
        const Fraction at{dot(line, t[j]) * heights[i] - dot(line, t[i]) * heights[j], bottom};
        if (first || at < interval.begin) interval.begin = at;
        if (first || interval.end < at) interval.end = at;
        first = false;
      }
    }
    interval.cut = true;
    return interval;
  }
};

/// Whether the edge pq goes from one side of the plane to the other through the triangle. `closed`:
/// its edges and corners belong to it.
bool edge_passes(const Vector3& p, const Vector3& q, const Triangle& t, bool closed) {
  if (orientation(t[0], t[1], t[2], p) * orientation(t[0], t[1], t[2], q) >= 0) return false;
  const auto [least, most] =
      std::minmax({orientation(p, q, t[0], t[1]), orientation(p, q, t[1], t[2]),
                   orientation(p, q, t[2], t[0])});
  return closed ? least * most >= 0 : least * most > 0;
}

bool an_edge_passes(const Triangle& s, const Triangle& t, bool closed) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (edge_passes(s[i], s[(i + 1) % 3], t, closed)) return true;
    if (edge_passes(t[i], t[(i + 1) % 3], s, closed)) return true;
  }
  return false;
}

bool has_area(const Triangle& t) { return (t[1] - t[0]).cross(t[2] - t[0]).norm() > 0; }

TEST(TrianglesCross, EqualsTheOracleOnIntegers) {
  // On a lattice this small every kind of contact comes up. Scaled by powers of two and shifted,
  // the corners stay exact, so the answer must stay the same.
  std::mt19937_64 random(1);
  int crossing = 0, touching = 0;
  for (int trial = 0; trial < 60000; ++trial) {
    const std::uint64_t size = 2 + random() % 4;
    std::array<Oracle::IntegerTriangle, 2> exact;
    std::array<Triangle, 2> plain, tiny, far;
    for (std::size_t k = 0; k < 2; ++k) {
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          exact[k][i][axis] = static_cast<std::int64_t>(random() % size);
          const auto x = static_cast<double>(exact[k][i][axis]);
          const auto a = static_cast<Eigen::Index>(axis);
          plain[k][i][a] = x;
          tiny[k][i][a] = 0x1p-30 * x;
          far[k][i][a] = 1e6 + 0x1p-30 * x;
        }
      }
    }
    const bool expected = Oracle::cross(exact[0], exact[1]);
    ASSERT_EQ(triangles_cross(plain[0], plain[1]), expected) << trial;
    ASSERT_EQ(triangles_cross(tiny[0], tiny[1]), expected) << trial;
    ASSERT_EQ(triangles_cross(far[1], far[0]), expected) << trial;
    if (trial % 10 == 0) {
      ASSERT_EQ(cross_in_every_order(plain[0], plain[1]), expected) << trial;
    }

    // Equivalently: an edge of one passes through the other.
    const bool through = an_edge_passes(plain[0], plain[1], false);
    const bool through_or_along = an_edge_passes(plain[0], plain[1], true);
    if (through && has_area(plain[0]) && has_area(plain[1])) {
      ASSERT_TRUE(expected) << trial;
    }
    if (expected) {
      ASSERT_TRUE(through_or_along) << trial;
    }
    crossing += expected;
    touching += through_or_along && !expected;
  }
  EXPECT_GT(crossing, 2000);
  EXPECT_GT(touching, 2000);
}

TEST(TrianglesCross, IsAnEdgeThroughTheOtherInGeneralPosition) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> unit(0, 1);
  int crossing = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    std::array<Triangle, 2> pair;
    for (Triangle& t : pair) {
      for (Vector3& corner : t) corner = {unit(random), unit(random), unit(random)};
    }
    const bool expected = an_edge_passes(pair[0], pair[1], false);
    ASSERT_EQ(triangles_cross(pair[0], pair[1]), expected) << trial;
    crossing += expected;
  }
  EXPECT_GT(crossing, 2000);
}

// ---- Meshes -------------------------------------------------------------------------------------

std::vector<std::pair<int, int>> by_all_pairs(const Cloth& cloth, const Points& positions) {
  std::vector<std::pair<int, int>> pairs;
  const auto corners = [&](const std::array<int, 3>& ids) {
    return Triangle{Vector3(positions.row(ids[0])), Vector3(positions.row(ids[1])),
                    Vector3(positions.row(ids[2]))};
  };
  const int n = static_cast<int>(cloth.triangles.size());
  for (int a = 0; a < n; ++a) {
    for (int b = a + 1; b < n; ++b) {
      const auto& s = cloth.triangles[static_cast<std::size_t>(a)];
      const auto& t = cloth.triangles[static_cast<std::size_t>(b)];
      const bool apart = std::none_of(
          s.begin(), s.end(), [&t](int i) { return std::find(t.begin(), t.end(), i) != t.end(); });
      if (apart && triangles_cross(corners(s), corners(t))) pairs.emplace_back(a, b);
    }
  }
  return pairs;
}

/// Checks the pairs against all pairs, and returns how many there are.
int checked_count(const Cloth& cloth, const Points& positions, const std::string& name) {
  std::vector<std::pair<int, int>> pairs;
  for (const TrianglePair& p : find_intersections(cloth, positions)) pairs.emplace_back(p.a, p.b);
  EXPECT_EQ(pairs, by_all_pairs(cloth, positions)) << name;
  EXPECT_EQ(count_intersections(cloth, positions), static_cast<int>(pairs.size())) << name;
  return static_cast<int>(pairs.size());
}

/// Triangles of any three points.
Cloth random_mesh(int points, int triangles, std::mt19937_64& random) {
  Cloth cloth;
  while (static_cast<int>(cloth.triangles.size()) < triangles) {
    const auto id = [&] { return static_cast<int>(random() % static_cast<unsigned>(points)); };
    const std::array<int, 3> ids{id(), id(), id()};
    if (ids[0] != ids[1] && ids[1] != ids[2] && ids[2] != ids[0]) cloth.triangles.push_back(ids);
  }
  return cloth;
}

TEST(FindIntersections, EqualsAllPairsOnRandomAndDegenerateMeshes) {
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 5; ++trial) {
    const Cloth cloth = random_mesh(60, 200, random);
    Points box(60, 3);
    for (double& x : box.reshaped()) x = static_cast<double>(random() >> 11) * 0x1p-53;

    EXPECT_GT(checked_count(cloth, box, "in a box"), 100);
    EXPECT_GT(checked_count(cloth, 1e-9 * box, "tiny"), 100);
    EXPECT_GT(checked_count(cloth, (1e6 + box.array()).matrix(), "far"), 100);
    EXPECT_GT(checked_count(cloth, (1e6 + 1e-9 * box.array()).matrix(), "tiny and far"), 10);

    const Points lattice =
        (4 * box).array().floor();  // coplanar, touching, of no area, twice there
    EXPECT_GT(checked_count(cloth, lattice, "on a lattice"), 100);
    Points huge = box;
    huge.topRows(2) *= 1e6;
    EXPECT_GT(checked_count(cloth, huge, "a few huge ones"), 100);

    Points flat = box;
    flat.col(2).setConstant(0.1);
    EXPECT_EQ(checked_count(cloth, flat, "in a plane"), 0);
    flat.col(2) = flat.col(0);
    EXPECT_EQ(checked_count(cloth, flat, "in a sloping plane"), 0);
    flat.col(1) = flat.col(0);
    EXPECT_EQ(checked_count(cloth, flat, "on a line"), 0);
    flat.setConstant(0.1);
    EXPECT_EQ(checked_count(cloth, flat, "in a point"), 0);
  }
}

ClothSpec square(int points) {
  ClothSpec spec;
  spec.columns = spec.rows = points;
  return spec;
}

TEST(FindIntersections, EqualsAllPairsOnCrumpledCloth) {
  const Cloth cloth = make_grid(square(20));
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> noise(-1, 1);
  for (const double amplitude : {0.05, 0.1, 1.0}) {
    Points positions = cloth.rest_positions;
    for (double& x : positions.reshaped()) x += amplitude * noise(random);
    EXPECT_GT(checked_count(cloth, positions, std::to_string(amplitude)), 10);
  }
}

TEST(FindIntersections, NothingWhereNothingCrosses) {
  ClothSpec spec = square(30);
  EXPECT_EQ(count_intersections(make_grid(spec), make_grid(spec).rest_positions), 0);
  spec.orientation = Orientation::vertical;
  const Cloth cloth = make_grid(spec);
  EXPECT_EQ(count_intersections(cloth, start_state(spec, cloth, 1).positions), 0);

  // Tilted, so that no coordinate is exact any more.
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1, Vector3(1, 2, 3).normalized()).matrix();
  EXPECT_EQ(count_intersections(cloth, cloth.rest_positions * turn), 0);

  spec.columns = 1;  // a chain has no triangles
  EXPECT_EQ(count_intersections(make_grid(spec), make_grid(spec).rest_positions), 0);
}

TEST(FindIntersections, ListsPairsThatShareNoPoint) {
  // Two triangles make a square, cut along x = y.
  Cloth cloth;
  cloth.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {7, 8, 9}, {0, 10, 11}, {4, 12, 13}};
  Points positions(14, 3);
  positions << 0, 0, 0, 4, 0, 0, 4, 4, 0, 0, 4, 0,  // the square
      3, 1, -1, 3, 1, 1, 3.5, 1, 1,                 // through its first triangle
      2, 2, -1, 1, 3, 1, 3, 1, 1,                   // a corner through its diagonal
      3, 1, -1, 4, 1, 5,                            // through the first, but hangs on its point
      3, 2, 1, 4, 2, 1;                             // beside it, and ends on the point of another
  ASSERT_EQ(checked_count(cloth, positions, "square"), 4);
  const auto pairs = find_intersections(cloth, positions);
  const int expected[][2] = {{0, 2}, {0, 3}, {0, 5}, {1, 3}};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(pairs[i].a, expected[i][0]) << i;
    EXPECT_EQ(pairs[i].b, expected[i][1]) << i;
  }
}

}  // namespace
}  // namespace clothsim::intersections_test
