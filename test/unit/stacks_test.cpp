#include "clothsim/constraints/stacks.h"

#include <algorithm>
#include <random>
#include <vector>

#include "verification/testing.h"

namespace clothsim::stacks_test {
namespace {

using namespace test;

constexpr double h = 0.001;          // [s]
constexpr double thickness = 0.002;  // of a layer [m]

/// Points without springs, of a cloth of this thickness.
Cloth points_of_cloth(int count) {
  ClothSpec spec = chain_spec(std::max(count, 2), 1, 0);
  spec.thickness = thickness / 2;
  Cloth cloth = make_grid(spec);
  cloth.offset = thickness / 2;
  return cloth;
}

/// A slab below z = 0, or above z = gap, 2 m wide.
MovingCollider slab(double z, bool above) {
  ColliderSpec spec;
  spec.shape = Cuboid{{2, 2, 1}};
  spec.friction = 0.5;
  spec.pose.position = {0, 0, z + (above ? 0.5 : -0.5)};
  return MovingCollider(spec);
}

ContactPoint at_point(int i, const Vector3& normal) {
  return {ContactPoint::no_triangle, {i, i, i}, {1, 0, 0}, normal, 0};
}

SelfTouch touch(int above, int below) {
  return {{above, below, below, below}, {1, -1, 0, 0}, Vector3::UnitZ(), thickness};
}

SelfTouches all(const std::vector<SelfTouch>& list) {
  return [&list](const auto& visit) { std::for_each(list.begin(), list.end(), visit); };
}

/// Points one above the other, evenly between two slabs: the number that is pinched.
int pinched_of(int layers, double gap, bool touch_each_other = true) {
  const Cloth cloth = points_of_cloth(layers);
  const MovingCollider lower = slab(0, false), upper = slab(gap, true);
  Points x = Points::Zero(layers, 3);
  for (int i = 0; i < layers; ++i) x(i, 2) = (i + 0.5) * gap / layers;
  std::vector<SelfTouch> touches;
  for (int i = 1; i < layers && touch_each_other; ++i) touches.push_back(touch(i, i - 1));
  const ContactManifold a{lower, cloth.offset, {at_point(0, Vector3::UnitZ())}};
  const ContactManifold b{upper, cloth.offset, {at_point(layers - 1, -Vector3::UnitZ())}};
  const SelfTouches visit = all(touches);
  Pinches pinches;
  pinches.start_over(h);
  Stacks().pinch(a, b, cloth, x, h, &visit, pinches);
  return pinches.count();
}

TEST(Stacks, AnyNumberOfLayersIsPinchedWhereItHasLessRoomThanItNeeds) {
  for (int layers = 1; layers <= 6; ++layers) {
    EXPECT_EQ(pinched_of(layers, layers * thickness - 1e-6), layers);
    EXPECT_EQ(pinched_of(layers, layers * thickness + 1e-6), 0);
    EXPECT_EQ(pinched_of(layers, 0.2 * layers * thickness), layers);
  }
}

TEST(Stacks, WhatDoesNotTouchAcrossTheGapIsNoStack) {
  EXPECT_EQ(pinched_of(2, 1.5 * thickness, false), 0);
  EXPECT_EQ(pinched_of(4, 3 * thickness, false), 0);
}

TEST(Stacks, NothingIsHeldBetweenSurfacesThatDoNotFaceEachOther) {
  const Cloth cloth = points_of_cloth(1);
  const MovingCollider lower = slab(0, false), lower_too = slab(-1e-4, false);
  Points x = Points::Zero(1, 3);
  const ContactManifold a{lower, cloth.offset, {at_point(0, Vector3::UnitZ())}};
  const ContactManifold b{lower_too, cloth.offset, {at_point(0, Vector3::UnitZ())}};
  Pinches pinches;
  pinches.start_over(h);
  Stacks().pinch(a, b, cloth, x, h, nullptr, pinches);
  EXPECT_EQ(pinches.count(), 0);
}

TEST(Stacks, TriangleBetweenItsCornersIsHeldByAllThree) {
  // Fingers thinner than a cell touch it at none of its corners.
  ClothSpec spec;
  spec.columns = spec.rows = 2;
  Cloth cloth = make_grid(spec);
  cloth.offset = thickness / 2;
  const double gap = 0.5 * thickness;
  ColliderSpec below, above;
  below.shape = above.shape = Sphere{0.01};
  const auto& corners = cloth.triangles[0];
  const Vector3 middle =
      (row(cloth.rest_positions, corners[0]) + row(cloth.rest_positions, corners[1]) +
       row(cloth.rest_positions, corners[2])) /
      3;
  const Vector3 normal = Vector3::UnitZ();
  below.pose.position = middle - (0.01 + gap / 2) * normal;
  above.pose.position = middle + (0.01 + gap / 2) * normal;
  const MovingCollider lower(below), upper(above);
  const std::array<double, 3> weights{1.0 / 3, 1.0 / 3, 1.0 / 3};
  const ContactManifold a{lower, cloth.offset, {{0, corners, weights, normal, gap / 2}}};
  const ContactManifold b{upper, cloth.offset, {{0, corners, weights, -normal, gap / 2}}};
  Pinches pinches;
  pinches.start_over(h);
  Stacks().pinch(a, b, cloth, cloth.rest_positions, h, nullptr, pinches);
  EXPECT_EQ(pinches.count(), 3);
  EXPECT_TRUE(pinches.holds_any({corners[0], corners[0], corners[0]}));
}

/// Layers below a point, over all paths down.
int layers_below(int point, const std::vector<std::vector<int>>& lies_on) {
  int most = 0;
  for (const int below : lies_on[static_cast<std::size_t>(point)]) {
    most = std::max(most, 1 + layers_below(below, lies_on));
  }
  return most;
}

TEST(Stacks, NeedTheLongestChainThatBruteForceFinds) {
  // Random heaps: each point lies on some lower ones, or on the slab, and below the other slab if
  // nothing lies on it.
  std::mt19937 random(5);
  constexpr int points = 12;
  int some = 0, others = 0;
  for (int round = 0; round < 200; ++round) {
    const Cloth cloth = points_of_cloth(points);
    std::uniform_real_distribution<double> height(0.001, 0.007);
    Points x = Points::Zero(points, 3);
    for (int i = 0; i < points; ++i) x(i, 2) = height(random);
    std::vector<SelfTouch> touches;
    std::vector<std::vector<int>> supports(points), under(points);
    for (int i = 0; i < points; ++i) {
      for (int j = 0; j < points; ++j) {
        if (x(i, 2) <= x(j, 2) || random() % 4 != 0) continue;
        touches.push_back(touch(i, j));
        supports[static_cast<std::size_t>(i)].push_back(j);
        under[static_cast<std::size_t>(j)].push_back(i);
      }
    }
    std::shuffle(touches.begin(), touches.end(), random);
    const double gap = 0.0075;  // between three layers and four
    const MovingCollider lower = slab(0, false), upper = slab(gap, true);
    ContactManifold a{lower, cloth.offset, {}}, b{upper, cloth.offset, {}};
    for (int i = 0; i < points; ++i) {
      if (supports[static_cast<std::size_t>(i)].empty()) {
        a.contact_points.push_back(at_point(i, Vector3::UnitZ()));
      }
      if (under[static_cast<std::size_t>(i)].empty()) {
        b.contact_points.push_back(at_point(i, -Vector3::UnitZ()));
      }
    }
    const SelfTouches visit = all(touches);
    Pinches pinches;
    pinches.start_over(h);
    Stacks().pinch(a, b, cloth, x, h, &visit, pinches);
    for (int i = 0; i < points; ++i) {
      const int layers = layers_below(i, supports) + layers_below(i, under) + 1;
      EXPECT_EQ(pinches.holds(i), layers * thickness > gap) << round << ' ' << i;
      ++(pinches.holds(i) ? some : others);
    }
  }
  EXPECT_GT(some, 100);
  EXPECT_GT(others, 100);
}

}  // namespace
}  // namespace clothsim::stacks_test
