#include "clothsim/search/near_pairs.h"

#include <cmath>

#include "surface_testing.h"

namespace clothsim::near_pairs_test {
namespace {

using namespace test;

constexpr double pi = 3.14159265358979323846;

/// The cloth rolled up along x with so many turns.
Points rolled(const Cloth& cloth, double turns) {
  Points x = cloth.rest_positions;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const double angle = 2 * pi * turns * x(i, 0);
    const double radius = 0.03 + 0.004 * angle;
    x(i, 0) = radius * std::cos(angle);
    x(i, 2) = radius * std::sin(angle);
  }
  return x;
}

/// Whether they are the same triangle, or there is at most one triangle between them.
bool are_beside(const SurfaceMesh& mesh, int s, int t) {
  const auto touch = [&](int p, int q) {
    const auto &a = mesh.triangles[static_cast<std::size_t>(p)],
               &b = mesh.triangles[static_cast<std::size_t>(q)];
    return std::find_first_of(a.begin(), a.end(), b.begin(), b.end()) != a.end();
  };
  const auto& corners = mesh.triangles[static_cast<std::size_t>(s)];
  return std::any_of(corners.begin(), corners.end(), [&](int corner) {
    const auto& around = mesh.around_point[static_cast<std::size_t>(corner)];
    return std::any_of(around.begin(), around.end(), [&](int p) { return touch(p, t); });
  });
}

/// For each point and triangle closer than `share` of their contact distance, that triangle was
/// found or an adjacent one that is nearly as near.
void expect_all_that_touches(const Surface& surface, const std::vector<NearPair>& found,
                             const Points& x, double share) {
  const SurfaceMesh& mesh = surface.mesh;
  std::vector<std::vector<const NearPair*>> of_point(mesh.around_point.size());
  for (const NearPair& near : found) {
    const Separation s = separation(near.pair, x);
    EXPECT_EQ(near.separation.distance, s.distance);
    EXPECT_EQ(near.pair.nearest, surface.nearest_of(near.pair));
    if (near.pair.edges()) continue;
    of_point[static_cast<std::size_t>(near.pair.points[0])].push_back(&near);
  }
  brute_force(surface, [&](const SurfacePair& pair) {
    if (pair.edges()) return false;
    const double distance = separation(pair, x).distance, slack = 0.1 * pair.nearest;
    if (distance > share * pair.nearest) return false;
    const auto& of = of_point[static_cast<std::size_t>(pair.points[0])];
    EXPECT_TRUE(std::any_of(of.begin(), of.end(),
                            [&](const NearPair* near) {
                              const double of_near = near->separation.distance;
                              return are_beside(mesh, near->pair.triangle, pair.triangle) &&
                                     (of_near <= distance + slack ||
                                      of_near - near->pair.nearest <=
                                          distance - pair.nearest + slack);
                            }))
        << pair.points[0] << ' ' << pair.triangle << ' ' << distance;
    return false;
  });
}

/// All pairs that come as near as `floor` on the way are found.
void expect_all_that_meet(const Surface& surface, NearPairs& finder, const Points& here,
                          const Points& ends, double floor) {
  const auto found = sorted_features(finder.swept_query(here, ends, floor));
  ASSERT_LE(finder.max_approach(), finder.sees());
  for (const double time : {0.0, 0.2, 0.4, 0.6, 0.8, 1.0}) {
    const Points at = here + time * (ends - here);
    const auto must = sorted_features(brute_force(
        surface, [&](const SurfacePair& pair) { return separation(pair, at).distance <= floor; }));
    EXPECT_TRUE(std::includes(found.begin(), found.end(), must.begin(), must.end())) << time;
  }
  const double way = 2 * longest_row(ends - here);
  const auto may = sorted_features(brute_force(surface, [&](const SurfacePair& pair) {
    return separation(pair, here).distance <= way + floor;
  }));
  EXPECT_TRUE(std::includes(may.begin(), may.end(), found.begin(), found.end()));
}

TEST(NearPairs, NoneOnAFlatClothHoweverThick) {
  for (const double thickness : {0.001, 0.0095, 0.2}) {
    const Cloth cloth = cloth_of(20, 15, thickness);
    NearPairs finder(cloth);
    const Points& x = cloth.rest_positions;
    EXPECT_TRUE(finder.approaching(x, x).empty()) << thickness;
    EXPECT_TRUE(finder.swept_query(x, x, 1e-6).empty()) << thickness;
  }
}

TEST(NearPairs, MissNothingThatMeetsOnAClothInAnyShape) {
  const Cloth cloth = cloth_of(14, 9, 0.02);
  const double floor = 0.004;
  Points line = cloth.rest_positions;
  line.rightCols(2).setZero();
  const std::vector<Points> shapes{shaken(cloth, 0.05, 1),
                                   random_points(cloth.num_points(), 0.15, 2), rolled(cloth, 2.5),
                                   line, Points::Zero(cloth.num_points(), 3)};
  for (const Points& x : shapes) {
    for (const double way : {0.0, 0.01, 0.05}) {
      NearPairs finder(cloth);
      expect_all_that_meet(cloth, finder, x, x + random_points(cloth.num_points(), way, 7), floor);
    }
  }
}

TEST(NearPairs, MissNothingThatMeetsOrTouchesWhileTheClothMoves) {
  // Rolled up step by step with all points trembling, then drifting and turning as a whole.
  const Cloth cloth = cloth_of(17, 6, 0.015);
  NearPairs finder(cloth);
  std::size_t most = 0;
  const auto at = [&](int step) -> Points {
    const double share = std::min(step, 240) / 240.0;
    const Eigen::AngleAxisd turn(0.012 * step, Vector3(1, 2, 3).normalized());
    const Points x = (1 - share) * cloth.rest_positions + share * rolled(cloth, 2) +
                     random_points(cloth.num_points(), 1e-3, static_cast<std::uint64_t>(step));
    const Points turned = x * turn.toRotationMatrix().transpose();
    return turned.rowwise() + 0.005 * step * Eigen::RowVector3d(1, -2, 3);
  };
  for (int step = 0; step < 260; ++step) {
    SCOPED_TRACE(step);
    const Points here = at(step), ends = at(step + 1);
    const std::vector<NearPair> found = finder.approaching(here, ends);
    expect_all_that_touches(cloth, found, here, 0.7);
    if (step > 240) {
      expect_all_that_meet(cloth, finder, here, ends, 0.002);
    } else {
      finder.swept_query(here, ends, 0.002);
    }
    finder.go(ends);
    most = std::max(most, found.size());
  }
  EXPECT_GT(most, 50u);
}

TEST(NearPairs, FindWhatTouchesOnACrumpledClothAtOnce) {
  const Cloth cloth = cloth_of(25, 25, 0.01);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    NearPairs finder(cloth);
    const Points x = random_points(cloth.num_points(), 0.4, seed);
    expect_all_that_touches(cloth, finder.approaching(x, x), x, 1);
  }
}

TEST(NearPairs, ListEdgesThatCrossWhereNoPointSeesIt) {
  // Two corners of a strip folded so that its borders cross far from any point.
  const Cloth cloth = strip(8);
  const State state = folded(cloth, 1.5 * strip_thickness, Eigen::RowVector3d(0.05, -0.05, 0));
  NearPairs finder(cloth);
  const auto found = sorted_features(finder.approaching(state.positions, state.positions));
  const auto must = sorted_features(brute_force(cloth, [&](const SurfacePair& pair) {
    const Separation s = separation(pair, state.positions);
    return pair.edges() && s.distance < pair.nearest &&
           std::all_of(s.weights.begin(), s.weights.end(), [](double w) { return w != 0; });
  }));
  EXPECT_GT(must.size(), 1u);
  EXPECT_TRUE(std::includes(found.begin(), found.end(), must.begin(), must.end()));
}

/// All pairs of points that are no neighbours at rest and come within some distance [m]: as they
/// lie, or along the line between them on the way to `ahead`.
std::vector<std::array<int, 2>> near_points(const Cloth& cloth, const Points& x,
                                            const Points& ahead, double within) {
  std::vector<std::array<int, 2>> found;
  for (int a = 0; a < cloth.num_points(); ++a) {
    for (int b = a + 1; b < cloth.num_points(); ++b) {
      const double at_rest = (row(cloth.rest_positions, a) - row(cloth.rest_positions, b)).norm();
      if (at_rest < 4 * cloth.thickness * (1 - 1e-9)) continue;
      const Vector3 way = row(x, a) - row(x, b);
      const double then = way.normalized().dot(row(ahead, a) - row(ahead, b));
      if (std::min(way.norm(), then) <= within) found.push_back({a, b});
    }
  }
  return found;
}

std::vector<std::array<int, 2>> points_of(const std::vector<NearPair>& pairs) {
  std::vector<std::array<int, 2>> points;
  for (const NearPair& near : pairs) points.push_back({near.pair.points[0], near.pair.points[2]});
  for (auto& [a, b] : points) {
    if (a > b) std::swap(a, b);
  }
  std::sort(points.begin(), points.end());
  return points;
}

TEST(NearPairs, OfPointsAreAllThatAreNearWhileTheClothMoves) {
  // Sheets and chains that roll up with all points trembling, flung and turned.
  for (const auto& [columns, rows] : {std::pair(17, 6), std::pair(1, 90), std::pair(90, 1)}) {
    const Cloth cloth = cloth_of(columns, rows, 0.012);
    NearPairs finder(cloth, Tiling::of_points);
    std::size_t most = 0;
    for (int step = 0; step < 200; ++step) {
      const double share = std::min(step, 150) / 150.0;
      const Points x = (1 - share) * cloth.rest_positions +
                       share * random_points(cloth.num_points(), 0.12, 7) +
                       random_points(cloth.num_points(), 2e-3, static_cast<std::uint64_t>(step));
      const Points ahead =
          x + random_points(cloth.num_points(), 0.02, static_cast<std::uint64_t>(1000 + step));
      const auto found = points_of(finder.approaching(x, ahead));
      const auto must = near_points(cloth, x, ahead, 2 * cloth.thickness),
                 may = near_points(cloth, x, ahead, 3 * cloth.thickness);
      ASSERT_TRUE(std::includes(found.begin(), found.end(), must.begin(), must.end())) << step;
      ASSERT_TRUE(std::includes(may.begin(), may.end(), found.begin(), found.end())) << step;
      most = std::max(most, must.size());
      if (step == 100) finder.forget();
    }
    EXPECT_GT(most, 40u) << columns << " x " << rows;
  }
}

TEST(NearPairs, OfPointsAreNoneOnFewPointsThatAreFar) {
  for (const auto& [columns, rows] : {std::pair(2, 1), std::pair(1, 2), std::pair(2, 2)}) {
    const Cloth cloth = cloth_of(columns, rows, 0.01);
    NearPairs finder(cloth, Tiling::of_points);
    EXPECT_TRUE(finder.approaching(cloth.rest_positions, cloth.rest_positions).empty());
  }
}

TEST(NearPairs, RefuseAMemoryOfEdgesThatTheClothLacks) {
  const Cloth cloth = cloth_of(17, 6, 0.015);
  MemoryWriter memory;
  memory.add(1);
  memory.add(cloth.rest_positions);
  for (const int looks_and_nearer : {0, 0}) memory.add(looks_and_nearer);
  for (int slots = 0; slots < cloth.num_points(); ++slots) memory.add(0);
  memory.add(1);                                               // pair of patches
  for (const int pair : {0, 1, 0, 0, 0, 1}) memory.add(pair);  // with two edges
  const int last = cloth.num_points() - 1, diagonals = Tiling::own_points - 1;
  for (const int edges : {last, 0, diagonals, 0}) memory.add(edges);
  MemoryReader reader(memory.numbers());
  EXPECT_THROW(NearPairs(cloth).read(reader), InvalidValue);
}

TEST(NearPairs, RefuseAMemoryOutOfOrder) {
  const Cloth cloth = cloth_of(17, 6, 0.015);
  const auto read = [&](const std::vector<int>& slots_of_first, const std::vector<int>& patches) {
    MemoryWriter memory;
    memory.add(1);
    memory.add(cloth.rest_positions);
    for (const int looks_and_nearer : {0, 0}) memory.add(looks_and_nearer);
    memory.add(static_cast<double>(slots_of_first.size()));
    for (const int number : slots_of_first) {
      for (const int slot : {number, 60}) memory.add(slot);
    }
    for (int point = 1; point < cloth.num_points(); ++point) memory.add(0);
    memory.add(static_cast<double>(patches.size() / 2));
    for (std::size_t k = 0; k < patches.size(); k += 2) {
      for (const int pair : {patches[k], patches[k + 1], 0, 0, 0, 0}) memory.add(pair);
    }
    MemoryReader reader(memory.numbers());
    NearPairs(cloth).read(reader);
    reader.finish();
  };
  EXPECT_NO_THROW(read({0, 1}, {0, 0, 0, 1}));
  EXPECT_THROW(read({1, 0}, {0, 0, 0, 1}), InvalidValue);
  EXPECT_THROW(read({0, 0}, {0, 0, 0, 1}), InvalidValue);
  EXPECT_THROW(read({0, 1}, {0, 1, 0, 0}), InvalidValue);
  EXPECT_THROW(read({0, 1}, {0, 0, 0, 0}), InvalidValue);
  EXPECT_THROW(read({0, 1}, {1, 0}), InvalidValue);
}

TEST(NearPairs, GoOnToTheSameWithTheirMemory) {
  const Cloth cloth = cloth_of(17, 6, 0.015);
  NearPairs finder(cloth), other(cloth);
  const auto at = [&](int step) -> Points {
    return rolled(cloth, 1.5 + 0.01 * step) +
           random_points(cloth.num_points(), 1e-3, static_cast<std::uint64_t>(step));
  };
  for (int step = 0; step < 40; ++step) {
    if (step == 20) {
      MemoryWriter memory;
      finder.write(memory);
      MemoryReader reader(memory.numbers());
      other.read(reader);
      reader.finish();
    }
    const auto look = [&](NearPairs& of) {
      const std::vector<NearPair> near = of.approaching(at(step), at(step + 1));
      std::vector<NearPair> meets = of.swept_query(at(step), at(step + 1), 0.002);
      of.go(at(step + 1));
      meets.insert(meets.begin(), near.begin(), near.end());
      return meets;
    };
    const std::vector<NearPair> found = look(finder);
    if (step < 20) continue;
    const std::vector<NearPair> of_other = look(other);
    ASSERT_EQ(found.size(), of_other.size()) << step;
    for (std::size_t k = 0; k < found.size(); ++k) {
      EXPECT_EQ(found[k].key, of_other[k].key);
      EXPECT_EQ(found[k].pair.points, of_other[k].pair.points);
      EXPECT_EQ(found[k].separation.distance, of_other[k].separation.distance);
    }
  }
}

TEST(NearPairs, HaveKeysThatAscendAndForgetWhatCameBefore) {
  const Cloth cloth = cloth_of(17, 6, 0.015);
  NearPairs moving(cloth), fresh(cloth);
  const Points x = rolled(cloth, 2);
  const Points ahead = x + random_points(cloth.num_points(), 1e-3, 1);
  for (const double share : {0.0, 0.5, 0.8, 0.9}) {
    moving.approaching((1 - share) * cloth.rest_positions + share * x, ahead);
  }
  moving.forget();
  const std::vector<NearPair> of_moving = moving.approaching(x, ahead);
  const std::vector<NearPair> of_fresh = fresh.approaching(x, ahead);
  ASSERT_EQ(of_moving.size(), of_fresh.size());
  ASSERT_GT(of_fresh.size(), 50u);
  for (std::size_t k = 0; k < of_fresh.size(); ++k) {
    EXPECT_EQ(of_moving[k].key, of_fresh[k].key);
    EXPECT_EQ(of_moving[k].separation.distance, of_fresh[k].separation.distance);
    if (k > 0) {
      EXPECT_LT(of_fresh[k - 1].key, of_fresh[k].key);
    }
  }
}

}  // namespace
}  // namespace clothsim::near_pairs_test
