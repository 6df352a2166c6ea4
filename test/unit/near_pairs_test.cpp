#include "clothsim/collision/near_pairs.h"

#include <cmath>

#include "clothsim/collision/distances.h"
#include "clothsim/collision/feature_pairs.h"
#include "clothsim/collision/nearest_distances.h"
#include "clothsim/collision/patches.h"
#include "clothsim/collision/unfolded.h"
#include "verification/testing.h"

namespace clothsim {
namespace {

using namespace testing;

constexpr double pi = 3.14159265358979323846;

Cloth cloth_of(int columns, int rows, double thickness) {
  ClothSpec spec;
  spec.columns = columns;
  spec.rows = rows;
  spec.origin = Vector3::Zero();
  spec.thickness = thickness;
  return make_grid(spec);
}

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

/// Every point and triangle, edge and edge that share no point and lie so that `chosen` holds.
template <typename Chosen>
std::vector<SurfacePair> brute_force(const Cloth& cloth, const Chosen& chosen) {
  const SurfaceMesh mesh(cloth);
  const NearestDistances nearest(cloth);
  std::vector<SurfacePair> pairs;
  const auto consider = [&](SurfacePair pair) {
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (pair.points[i] == pair.points[j]) return;
      }
    }
    pair.nearest = nearest.of(pair);
    if (chosen(pair)) pairs.push_back(pair);
  };
  for (int i = 0; i < cloth.num_points(); ++i) {
    for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
      const auto& [a, b, c] = mesh.triangles[static_cast<std::size_t>(t)];
      consider({t, {i, a, b, c}, 0});
    }
  }
  for (int e = 0; e < static_cast<int>(mesh.edges.size()); ++e) {
    for (int f = 0; f < e; ++f) {
      const auto& [a, b] = mesh.edges[static_cast<std::size_t>(e)];
      const auto& [c, d] = mesh.edges[static_cast<std::size_t>(f)];
      consider({SurfacePair::no_triangle, {a, b, c, d}, 0});
    }
  }
  return pairs;
}

using Features = std::pair<int, std::array<int, 4>>;

/// Of two edges, in the order of their points.
Features features(const SurfacePair& pair) {
  auto [a, b, c, d] = pair.points;
  if (pair.edges() && std::pair(c, d) < std::pair(a, b)) {
    std::swap(a, c);
    std::swap(b, d);
  }
  return {pair.triangle, {a, b, c, d}};
}

std::vector<Features> sorted_features(const std::vector<NearPair>& pairs) {
  std::vector<Features> result;
  for (const NearPair& near : pairs) result.push_back(features(near.pair));
  std::sort(result.begin(), result.end());
  return result;
}

std::vector<Features> sorted_features(const std::vector<SurfacePair>& pairs) {
  std::vector<Features> result;
  for (const SurfacePair& pair : pairs) result.push_back(features(pair));
  std::sort(result.begin(), result.end());
  return result;
}

/// Pairs within the nearest they may come plus `margin`, and within `distance`.
void expect_equals_brute_force(const std::vector<NearPair>& found, const Cloth& cloth,
                               const Points& x, double margin, double distance) {
  const auto chosen = [&](const SurfacePair& pair) {
    const double d = separation(pair, x).distance;
    return d <= pair.nearest + margin && d <= distance;
  };
  const auto expected = sorted_features(brute_force(cloth, chosen));
  EXPECT_EQ(found.size(), expected.size());
  EXPECT_TRUE(sorted_features(found) == expected);
}

/// Whatever is asked for.
void expect_equals_brute_force(const Cloth& cloth, NearPairs& finder, const Points& x) {
  constexpr double any = 1e9;
  expect_equals_brute_force(finder.approaching(cloth, x, x), cloth, x, finder.least_margin(), any);
  const double close = 0.5 * finder.reach();
  expect_equals_brute_force(finder.within(cloth, x, close), cloth, x, any, close);

  // All near ones that meet on the way to anywhere else, and none that is far.
  const Points ahead = x + random_points(cloth.num_points(), 1, 7);
  const auto found = sorted_features(finder.approaching(cloth, x, ahead));
  const auto near = [&](const SurfacePair& pair, double margin) {
    return separation(pair, x).distance <= pair.nearest + margin;
  };
  const auto may_be_found = sorted_features(
      brute_force(cloth, [&](const SurfacePair& pair) { return near(pair, finder.margin()); }));
  EXPECT_TRUE(std::includes(may_be_found.begin(), may_be_found.end(), found.begin(), found.end()));
  std::vector<Points> on_the_way;
  for (const double share : {0.1, 0.3, 0.5, 1.0}) on_the_way.push_back(x + share * (ahead - x));
  const auto must_be_found = sorted_features(brute_force(cloth, [&](const SurfacePair& pair) {
    const auto meets = [&](const Points& there) {
      return separation(pair, there).distance <= pair.nearest;
    };
    return near(pair, finder.least_margin()) ||
           (near(pair, finder.margin()) &&
            std::any_of(on_the_way.begin(), on_the_way.end(), meets));
  }));
  EXPECT_TRUE(
      std::includes(found.begin(), found.end(), must_be_found.begin(), must_be_found.end()));
  const double reach = finder.reach();
  expect_equals_brute_force(finder.within(cloth, x, reach), cloth, x, any, reach);
}

TEST(NearPairs, NoneOnAFlatClothHoweverThick) {
  for (const double thickness : {0.001, 0.0095, 0.2}) {
    const Cloth cloth = cloth_of(20, 15, thickness);
    NearPairs finder(cloth);
    const Points& x = cloth.rest_positions;
    const Points ahead = x + random_points(cloth.num_points(), 1, 7);
    EXPECT_TRUE(finder.approaching(cloth, x, ahead).empty()) << thickness;
  }
}

TEST(NearPairs, EqualBruteForceOnAClothInAnyShape) {
  const Cloth cloth = cloth_of(14, 9, 0.02);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    NearPairs finder(cloth);
    expect_equals_brute_force(cloth, finder, shaken(cloth, 0.05, seed));
    NearPairs other(cloth);
    expect_equals_brute_force(cloth, other, random_points(cloth.num_points(), 0.15, seed));
  }
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {  // asked for at once, however near they are
    NearPairs fresh(cloth);
    const Points x = random_points(cloth.num_points(), 0.15, seed);
    constexpr double any = 1e9;
    const double close = 0.5 * fresh.reach();
    expect_equals_brute_force(fresh.within(cloth, x, close), cloth, x, any, close);
  }
  NearPairs finder(cloth);
  expect_equals_brute_force(cloth, finder, rolled(cloth, 2.5));
  NearPairs flat(cloth);
  Points line = cloth.rest_positions;
  line.rightCols(2).setZero();
  expect_equals_brute_force(cloth, flat, line);
}

TEST(NearPairs, EqualBruteForceWhileTheClothMoves) {
  // Rolled up step by step with all points trembling, then blown apart at once.
  const Cloth cloth = cloth_of(17, 6, 0.015);
  NearPairs finder(cloth);
  std::size_t most = 0;
  for (int step = 0; step < 60; ++step) {
    const double share = step / 60.0;
    const Points x = (1 - share) * cloth.rest_positions + share * rolled(cloth, 2) +
                     random_points(cloth.num_points(), 1e-3, static_cast<std::uint64_t>(step));
    expect_equals_brute_force(cloth, finder, x);
    most = std::max(most, finder.approaching(cloth, x, x).size());
  }
  EXPECT_GT(most, 50u);
  expect_equals_brute_force(cloth, finder, 3 * cloth.rest_positions);
  EXPECT_TRUE(finder.within(cloth, 3 * cloth.rest_positions, finder.reach()).empty());
}

TEST(NearPairs, MissNoneThatTouchesOnTheWayAhead) {
  // Also where the whole turns and moves far: that brings nothing nearer.
  const Cloth cloth = cloth_of(17, 6, 0.015);
  const Points x = rolled(cloth, 2);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    NearPairs finder(cloth);
    const Eigen::AngleAxisd turn(0.3, Vector3(1, 2, 3).normalized());
    const Points trembling = x + random_points(cloth.num_points(), 0.1 * finder.margin(), seed);
    const Points ahead = trembling * turn.toRotationMatrix().transpose();
    const auto found = sorted_features(finder.approaching(cloth, x, ahead));
    const auto touching = sorted_features(brute_force(cloth, [&](const SurfacePair& pair) {
      return separation(pair, ahead).distance <= pair.nearest;
    }));
    EXPECT_GT(touching.size(), 20u);
    EXPECT_TRUE(std::includes(found.begin(), found.end(), touching.begin(), touching.end()));
  }
}

TEST(NearPairs, HaveKeysThatAscendAndDoNotDependOnWhatCameBefore) {
  const Cloth cloth = cloth_of(17, 6, 0.015);
  NearPairs moving(cloth), fresh(cloth);
  const Points x = rolled(cloth, 2);
  const Points ahead = x + random_points(cloth.num_points(), 1e-3, 1);
  for (const double share : {0.0, 0.5, 0.8, 0.9}) {
    moving.approaching(cloth, (1 - share) * cloth.rest_positions + share * x, ahead);
  }
  const std::vector<NearPair> of_moving = moving.approaching(cloth, x, ahead);
  const std::vector<NearPair> of_fresh = fresh.approaching(cloth, x, ahead);
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

TEST(Distances, AreThoseOfEachPair) {
  // Of any points: also of triangles and edges without extent, and of features that meet.
  const int count = 40;
  Points x = random_points(count, 1, 3);
  for (int i = 0; i < 10; ++i) x.row(i) = x.row(i + 10);               // the same twice
  for (int i = 20; i < 30; ++i) x.row(i).tail(2) = x.row(20).tail(2);  // on a line
  Distances edges(true), triangles(false);
  std::vector<SurfacePair> pairs;
  std::uint64_t random = 1;
  const auto draw = [&] {
    random = random * 6364136223846793005u + 1442695040888963407u;
    return static_cast<int>((random >> 33) % count);
  };
  double most = 0;
  for (Distances* distances : {&edges, &triangles}) {
    for (int round = 0; round < 20; ++round) {
      pairs.clear();
      distances->clear();
      while (distances->room() > 0) {
        const int triangle = distances == &edges ? SurfacePair::no_triangle : 0;
        pairs.push_back({triangle, {draw(), draw(), draw(), draw()}, 0});
        distances->add(pairs.back().points);
      }
      distances->measure(x);
      for (std::size_t k = 0; k < pairs.size(); ++k) {
        const double exact = separation(pairs[k], x).distance;
        EXPECT_LE((*distances)[k], exact + 1e-12);
        EXPECT_GE((*distances)[k], (1 - 1e-10) * exact - 1e-6);
        most = std::max(most, exact);
      }
    }
  }
  EXPECT_GT(most, 1);
}

TEST(PatchMotions, BoundEveryChangeOfDistance) {
  const Cloth cloth = cloth_of(11, 10, 0.01);
  const std::vector<Patch> patches = cut_into_patches(cloth, 4);
  ASSERT_EQ(patches.size(), 9u);
  const Points from = shaken(cloth, 0.02, 1);
  const Eigen::AngleAxisd turn(1.1, Vector3(3, 1, 2).normalized());
  const Points turned = from * turn.toRotationMatrix().transpose();
  for (const double tremble : {0.0, 0.001, 0.5}) {
    const Points to = turned + random_points(cloth.num_points(), tremble, 2);
    PatchMotions motions;
    motions.follow(patches, from, to);
    for (std::size_t p = 0; p < patches.size(); ++p) {
      for (std::size_t q = 0; q < patches.size(); ++q) {
        const double bound = motions.between(static_cast<int>(p), static_cast<int>(q));
        EXPECT_LE(bound, 20 * tremble + 1e-12);
        for (const int i : patches[p].points) {
          for (const int j : patches[q].points) {
            const double before = (from.row(i) - from.row(j)).norm();
            const double after = (to.row(i) - to.row(j)).norm();
            EXPECT_LE(std::abs(after - before), bound + 1e-12);
          }
        }
      }
    }
  }
}

TEST(PatchMotions, BoundThemWhereAPatchIsSqueezedToALine) {
  const Cloth cloth = cloth_of(5, 9, 0.01);
  const std::vector<Patch> patches = cut_into_patches(cloth, 4);
  Points line = cloth.rest_positions;
  line.rightCols(2).setZero();
  PatchMotions motions;
  motions.follow(patches, cloth.rest_positions, line);
  double worst = 0;
  for (const int i : patches[0].points) {
    for (const int j : patches[1].points) {
      const auto distance = [&](const Points& x) { return (x.row(i) - x.row(j)).norm(); };
      worst = std::max(worst, std::abs(distance(line) - distance(cloth.rest_positions)));
    }
  }
  EXPECT_GE(motions.between(0, 1), worst);
}

TEST(NearestDistances, AreAQuarterOfThoseAtRestUpToTheContactDistance) {
  for (const double thickness : {0.004, 0.02, 0.1}) {
    ClothSpec spec;
    spec.columns = 8;
    spec.rows = 7;
    spec.height = 0.5;
    spec.thickness = thickness;
    const Cloth cloth = make_grid(spec);
    const NearestDistances nearest(cloth);
    const SurfaceMesh mesh(cloth);
    double least = 2 * thickness;
    const auto check = [&](const SurfacePair& pair, int cell, int other) {
      const double rest = separation(pair, cloth.rest_positions).distance;
      if (rest < 1e-9) return;  // they share a point
      const double expected = std::min(2 * thickness, rest / 4);
      EXPECT_NEAR(nearest.of(pair), expected, 1e-12);
      EXPECT_GE(nearest.most_of_cells(cell, other), expected - 1e-12);
      least = std::min(least, expected);
    };
    for (int p = 0; p < mesh.num_cells(); ++p) {
      for (int q = 0; q < mesh.num_cells(); ++q) {
        const auto cell = static_cast<std::size_t>(p), other = static_cast<std::size_t>(q);
        for (const int i : mesh.cell_points[cell]) {
          for (const int t : {2 * q, 2 * q + 1}) {
            const auto& [a, b, c] = mesh.triangles[static_cast<std::size_t>(t)];
            check({t, {i, a, b, c}, 0}, p, q);
          }
        }
        for (const int e : mesh.cell_edges[cell]) {
          for (const int f : mesh.cell_edges[other]) {
            const auto& [a, b] = mesh.edges[static_cast<std::size_t>(e)];
            const auto& [c, d] = mesh.edges[static_cast<std::size_t>(f)];
            check({SurfacePair::no_triangle, {a, b, c, d}, 0}, p, q);
          }
        }
      }
    }
    EXPECT_NEAR(nearest.least(), least, 1e-12);
  }
}

TEST(FeaturePairs, AreAllThatShareNoPointEachOnce) {
  for (const auto& [columns, rows] : {std::pair(6, 5), std::pair(2, 2), std::pair(2, 6)}) {
    const Cloth cloth = cloth_of(columns, rows, 0.01);
    const SurfaceMesh mesh(cloth);
    const FeaturePairs lists(mesh);
    std::vector<SurfacePair> found;
    for (int cell = 0; cell < mesh.num_cells(); ++cell) {
      for (int other = cell; other < mesh.num_cells(); ++other) {
        const std::array<int, 2> cells{cell, other};
        const std::array<int, 2> first = lists.first_points(cell, other);
        for (const FeaturePairs::Run& run : lists.of(cell, other)) {
          EXPECT_LE(run.size(), FeaturePairs::most);
          for (std::size_t k = 0; k < run.size(); ++k) {
            SurfacePair pair{SurfacePair::no_triangle, {}, 0};
            if (!run.edges) pair.triangle = 2 * cells[run.of[1]] + run.triangles[k];
            for (std::size_t i = 0; i < 4; ++i) {
              pair.points[i] = first[run.of_point(i)] + run.points[i][k];
            }
            found.push_back(pair);
          }
        }
      }
    }
    const auto all = brute_force(cloth, [](const SurfacePair&) { return true; });
    EXPECT_TRUE(sorted_features(found) == sorted_features(all)) << columns << " x " << rows;
  }
}

TEST(SurfaceMesh, HasEachFeatureOnce) {
  const Cloth cloth = cloth_of(5, 4, 0.01);
  const SurfaceMesh mesh(cloth);
  EXPECT_EQ(mesh.triangles.size(), 2u * 4 * 3);
  EXPECT_EQ(mesh.edges.size(), 4u * 4 + 5 * 3 + 4 * 3);  // along rows, columns, diagonals
  std::vector<int> points(20, 0), edges(mesh.edges.size(), 0);
  for (int cell = 0; cell < mesh.num_cells(); ++cell) {
    for (const int i : mesh.cell_points[static_cast<std::size_t>(cell)]) {
      ++points[static_cast<std::size_t>(i)];
    }
    for (const int e : mesh.cell_edges[static_cast<std::size_t>(cell)]) {
      ++edges[static_cast<std::size_t>(e)];
    }
  }
  EXPECT_EQ(points, std::vector<int>(20, 1));
  EXPECT_EQ(edges, std::vector<int>(mesh.edges.size(), 1));
}

TEST(Unfolded, BoundsTheDistancesOfARectangle) {
  // Bent, sheared and shaken rectangles: where it holds, no two points are nearer than it says.
  int held = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Cloth cloth = cloth_of(4, 5, 0.01);
    const Points random = random_points(3, 1, seed);
    Points x = shaken(cloth, 0.05, seed);
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      x(i, 2) += 0.5 * random(0, 0) * x(i, 0) * x(i, 1) + random(0, 1) * x(i, 0) * x(i, 0);
      x(i, 0) += random(1, 0) * x(i, 1);
    }
    const double least = least_stretch(gradient_bounds(cloth, x, 0, 0, 3, 4));
    if (least > 0.2) ++held;
    for (int i = 0; i < cloth.num_points(); ++i) {
      for (int j = 0; j < i; ++j) {
        const double rest = (cloth.rest_positions.row(i) - cloth.rest_positions.row(j)).norm();
        EXPECT_GE((x.row(i) - x.row(j)).norm(), least * rest - 1e-12);
      }
    }
  }
  EXPECT_GT(held, 20);
}

TEST(Unfolded, HoldsForAnyRigidMotionAndNotForAFold) {
  const Cloth cloth = cloth_of(6, 6, 0.01);
  const Eigen::AngleAxisd turn(2, Vector3(1, 2, 3).normalized());
  const Points turned = cloth.rest_positions * turn.toRotationMatrix().transpose();
  Points folded = cloth.rest_positions;
  folded.col(0) = (folded.col(0).array() - 0.5).abs();
  EXPECT_NEAR(least_stretch(gradient_bounds(cloth, turned, 0, 0, 5, 5)), 1, 1e-12);
  EXPECT_LT(least_stretch(gradient_bounds(cloth, folded, 0, 0, 5, 5)), 0.01);
}

}  // namespace
}  // namespace clothsim
