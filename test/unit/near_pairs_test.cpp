#include "clothsim/search/near_pairs.h"

#include <cmath>

#include "surface_testing.h"

namespace clothsim {
namespace {

using namespace testing;

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

/// Of points and triangles, and edges that are closest inside both.
bool is_inside(const SurfacePair& pair, const Separation& s) {
  return !pair.edges() ||
         std::all_of(s.weights.begin(), s.weights.end(), [](double w) { return w != 0; });
}

/// Pairs within the nearest they may come plus `margin`, and within `distance`; edges only where
/// they are closest `inside`, if so asked.
void expect_equals_brute_force(const std::vector<NearPair>& found, const Cloth& cloth,
                               const Points& x, double margin, double distance, bool inside) {
  const auto chosen = [&](const SurfacePair& pair) {
    const Separation s = separation(pair, x);
    return s.distance <= pair.nearest + margin && s.distance <= distance &&
           (!inside || is_inside(pair, s));
  };
  const auto expected = sorted_features(brute_force(cloth, chosen));
  EXPECT_EQ(found.size(), expected.size());
  EXPECT_TRUE(sorted_features(found) == expected);
}

/// Whatever is asked for.
void expect_equals_brute_force(const Cloth& cloth, NearPairs& finder, const Points& x) {
  constexpr double any = 1e9;
  expect_equals_brute_force(finder.approaching(cloth, x, x), cloth, x, finder.least_margin(), any,
                            true);
  const double close = 0.5 * finder.reach();
  expect_equals_brute_force(finder.within(cloth, x, close), cloth, x, any, close, false);

  // All near ones that meet on the way to anywhere else, and none that is far.
  const Points ahead = x + random_points(cloth.num_points(), 1, 7);
  const auto found = sorted_features(finder.approaching(cloth, x, ahead));
  const auto near = [&](const SurfacePair& pair, double margin) {
    const Separation s = separation(pair, x);
    return s.distance <= pair.nearest + margin && is_inside(pair, s);
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
  expect_equals_brute_force(finder.within(cloth, x, reach), cloth, x, any, reach, false);
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
    expect_equals_brute_force(fresh.within(cloth, x, close), cloth, x, any, close, false);
  }
  NearPairs finder(cloth);
  expect_equals_brute_force(cloth, finder, rolled(cloth, 2.5));
  NearPairs flat(cloth);
  Points line = cloth.rest_positions;
  line.rightCols(2).setZero();
  expect_equals_brute_force(cloth, flat, line);
}

TEST(NearPairs, EqualBruteForceWhereAllOfALargeClothIsCrumpled) {
  const Cloth cloth = cloth_of(25, 25, 0.01);
  NearPairs finder(cloth);
  const Points x = random_points(cloth.num_points(), 0.4, 2);
  constexpr double any = 1e9;
  expect_equals_brute_force(finder.approaching(cloth, x, x), cloth, x, finder.least_margin(), any,
                            true);
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

TEST(NearPairs, EqualBruteForceWhileTheClothHardlyMovesWithinItself) {
  // It drifts as a whole, rolls up slowly and trembles: what is near is kept over many steps.
  const Cloth cloth = cloth_of(17, 6, 0.015);
  NearPairs finder(cloth);
  const Points tremor = random_points(cloth.num_points(), 1, 5);
  std::size_t most = 0;
  for (int step = 0; step < 80; ++step) {
    const auto at = [&](double time) -> Points {
      const Points x = rolled(cloth, 1.9 + 5e-4 * time) + 2e-3 * std::sin(0.3 * time) * tremor;
      return x.rowwise() + 0.03 * time * Eigen::RowVector3d(1, -2, 3);
    };
    const Points x = at(step), ahead = at(step + 1);
    NearPairs fresh(cloth);
    const auto found = sorted_features(finder.approaching(cloth, x, ahead));
    EXPECT_TRUE(found == sorted_features(fresh.approaching(cloth, x, ahead))) << step;
    constexpr double any = 1e9;
    const double close = (step % 4 + 1) * 0.25 * finder.reach();
    expect_equals_brute_force(finder.within(cloth, x, close), cloth, x, any, close, false);
    const auto touching = sorted_features(brute_force(cloth, [&](const SurfacePair& pair) {
      const Separation s = separation(pair, x);
      return s.distance <= pair.nearest + finder.least_margin() && is_inside(pair, s);
    }));
    EXPECT_TRUE(std::includes(found.begin(), found.end(), touching.begin(), touching.end()));
    most = std::max(most, touching.size());
  }
  EXPECT_GT(most, 50u);
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
      return separation(pair, ahead).distance <= pair.nearest &&
             is_inside(pair, separation(pair, x));
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

}  // namespace
}  // namespace clothsim
