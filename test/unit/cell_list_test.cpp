#include "clothsim/geometry/cell_list.h"

#include <algorithm>
#include <cmath>

#include "verification/testing.h"

namespace clothsim {
namespace {

using namespace testing;

/// The same pairs, each against each.
std::vector<PointPair> all_pairs(const Points& x, double distance) {
  std::vector<PointPair> pairs;
  for (int a = 0; a < x.rows(); ++a) {
    for (int b = a + 1; b < x.rows(); ++b) {
      const double dx = x(a, 0) - x(b, 0);
      const double dy = x(a, 1) - x(b, 1);
      const double dz = x(a, 2) - x(b, 2);
      if (dx * dx + dy * dy + dz * dz < distance * distance) pairs.push_back({a, b});
    }
  }
  return pairs;
}

/// Compares, and returns how many pairs there are.
std::size_t expect_same(const Points& x, double distance) {
  static PairFinder finder;  // used over and over, as contact does
  std::vector<PointPair> pairs{{7, 8}};
  finder.find(x, distance, pairs);
  const std::vector<PointPair> expected = all_pairs(x, distance);
  EXPECT_TRUE(pairs == expected) << pairs.size() << " for " << expected.size() << " pairs";
  return expected.size();
}

TEST(PairFinder, EqualsAllPairsOnRandomPoints) {
  std::size_t found = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Points x = random_points(300, 1, seed);
    for (const double distance : {1e-4, 0.05, 0.2, 0.7, 5.0}) found += expect_same(x, distance);
    found += expect_same(x.array().rowwise() + Eigen::RowVector3d(-5, 3, -0.1).array(), 0.2);
  }
  EXPECT_GT(found, 1000u);
}

TEST(PairFinder, LeavesOutWhatItIsTold) {
  const Points x = random_points(300, 1, 11);
  const auto leaves_out = [](const PointPair& pair) { return (pair.a + pair.b) % 3 == 0; };
  std::vector<PointPair> expected = all_pairs(x, 0.2), pairs;
  const auto kept = std::remove_if(expected.begin(), expected.end(), leaves_out);
  EXPECT_GT(expected.end() - kept, 10);
  expected.erase(kept, expected.end());
  PairFinder().find(x, 0.2, pairs, nullptr, leaves_out);
  EXPECT_TRUE(pairs == expected) << pairs.size() << " for " << expected.size() << " pairs";
}

TEST(PairFinder, EqualsAllPairsOnFlatAndLinedUpPoints) {
  Points x = random_points(300, 1, 7);
  x.col(2).setZero();
  expect_same(x, 0.1);
  x.col(1).setConstant(-3);
  expect_same(x, 0.01);
}

TEST(PairFinder, EqualsAllPairsOnCellBorders) {
  // Points at whole multiples of the distance, on both sides of zero: all lie on borders, and
  // neighbours are exactly at, a hair under or a hair over the distance.
  for (const double scale : {1.0, 1 - 1e-15, 1 + 1e-15, 0.999, 1.001, 0.5}) {
    Points x(7 * 7 * 7, 3);
    for (int i = 0; i < 343; ++i) x.row(i) << i % 7 - 3, i / 7 % 7 - 3, i / 49 - 3;
    expect_same(0.019 * scale * x, 0.019);
  }
}

TEST(PairFinder, AllPointsInOnePlace) {
  for (const double at : {0.0, -2.5, 1e9}) {
    EXPECT_EQ(expect_same(Points::Constant(60, 3, at), 0.01), 60u * 59 / 2);
  }
}

TEST(PairFinder, FarAwayPoints) {
  // Beyond the range of cell indices, on every side, in clumps that must still find each other.
  Points x = random_points(240, 0.02, 9);
  for (int i = 0; i < 240; ++i) {
    const int place = i % 6;
    const double far = place % 2 == 0 ? 1e5 : -1e12;
    if (place > 0) x(i, place / 2) += far;
  }
  EXPECT_GT(expect_same(x, 0.02), 100u);
  // The first point, about which cells are counted, is the far one.
  x.row(0) << 1e15, -1e15, 1e15;
  expect_same(x, 0.02);
  x.row(0) << -1e300, 0, 0;
  expect_same(x, 0.02);
}

TEST(PairFinder, FewPoints) {
  expect_same(Points(0, 3), 0.1);
  expect_same(Points::Zero(1, 3), 0.1);
  EXPECT_EQ(expect_same(Points::Zero(2, 3), 0.1), 1u);
}

}  // namespace
}  // namespace clothsim
