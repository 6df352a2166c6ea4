#include "clothsim/geometry/surface_pair.h"

#include <array>

#include "verification/testing.h"

namespace clothsim::surface_pair_test {
namespace {

using namespace test;

constexpr std::array<SurfacePair, 2> pairs = {
    {{0, {0, 1, 2, 3}, 0}, {SurfacePair::no_triangle, {0, 1, 2, 3}, 0}}};

TEST(SurfacePair, AlongItsNormalTheGapIsItsDistance) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const Points x = random_points(4, 1, seed);
    const Vector3 other = row(random_points(1, 1, 1000 + seed), 0).normalized();
    for (const SurfacePair& pair : pairs) {
      const Separation s = separation(pair, x);
      if (s.distance < 1e-6) continue;
      EXPECT_NEAR(gap_along(s.normal, pair, x), s.distance, 1e-12);
      EXPECT_LE(gap_along(other, pair, x), s.distance + 1e-12);
    }
  }
}

TEST(SurfacePair, WhereItsGapIsPositiveAllAlongItsFeaturesNeverMeet) {
  int turning = 0;
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    const Points start = random_points(4, 1, 2 * seed), end = random_points(4, 1, 2 * seed + 1);
    for (const SurfacePair& pair : pairs) {
      if (min_gap_turning(pair, start, end) <= 0) continue;
      for (int k = 0; k <= 50; ++k) {
        const double t = k / 50.0;
        EXPECT_GT(separation(pair, (1 - t) * start + t * end).distance, 0) << seed << ' ' << t;
      }
      turning += gap_along(separation(pair, start).normal, pair, end) < 0;
    }
  }
  EXPECT_GT(turning, 100) << "of which no plane that stays is between them";
}

TEST(SurfacePair, FeaturesThatSwapSidesHaveNoGapAllAlong) {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    Points start = random_points(4, 1, 2 * seed), end = random_points(4, 1, 2 * seed + 1);
    // From above the triangle to below, and an edge from above another one to below.
    for (Points* x : {&start, &end}) {
      const double side = x == &start ? 0.1 : -0.1;
      *x *= 0.1;
      x->row(1) += Eigen::RowVector3d(-1, -1, 0);
      x->row(2) += Eigen::RowVector3d(1, -1, 0);
      x->row(3) += Eigen::RowVector3d(0, 1, 0);
      x->row(0) << 0, 0, 5 * side;
    }
    EXPECT_LE(min_gap_turning(pairs[0], start, end), 0) << seed;
    for (Points* x : {&start, &end}) {
      const double side = x == &start ? 0.5 : -0.5;
      *x << -1, 0, side, 1, 0, side, 0, -1, 0, 0, 1, 0;
      *x += random_points(4, 0.1, seed + 5000);
    }
    EXPECT_LE(min_gap_turning(pairs[1], start, end), 0) << seed;
  }
}

TEST(SurfacePair, WhatTurnsAsARigidBodyKeepsItsGap) {
  // For any axis: a turn by a small angle shrinks all chords by its square at most, and the
  // parabola is off by its cube, times the distance of the points to the side.
  const Eigen::Matrix3d tilt(Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()));
  constexpr double gap = 1e-4;
  Points point(4, 3), edges(4, 3);
  point << 0.2, 0.3, gap, -1, -1, 0, 1, -1, 0, 0, 1, 0;
  edges << -1, 0.1, gap, 1, 0.2, gap, 0.1, -1, 0, 0.2, 1, 0;
  for (const SurfacePair& pair : pairs) {
    const Points start = (pair.edges() ? edges : point) * tilt.transpose();
    for (const Vector3& axis : {Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(1, 2, -1)}) {
      for (const double angle : {0.02, -0.01}) {
        const Eigen::Matrix3d turn(Eigen::AngleAxisd(angle, axis.normalized()));
        EXPECT_NEAR(min_gap_turning(pair, start, start * turn.transpose()), gap, 0.05 * gap);
      }
    }
  }
}

}  // namespace
}  // namespace clothsim::surface_pair_test
