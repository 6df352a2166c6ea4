#include "clothsim/constraints/pinches.h"

#include <cmath>
#include <random>
#include <set>

#include "verification/testing.h"

namespace clothsim {
namespace {

using namespace testing;

constexpr double h = 0.01;  // [s]

/// Of a surface that faces `normal`, goes at `velocity` and is `gap` away.
ContactImpulse contact(const Vector3& normal, const Vector3& velocity, double gap,
                       double friction) {
  ContactImpulse result;
  result.normal = normal;
  result.surface_velocity = velocity;
  result.slowest = -gap / h;
  result.friction = friction;
  return result;
}

/// That goes at `velocity`.
MovingCollider moving(const Vector3& velocity) {
  ColliderSpec spec;
  spec.shape = Sphere{0.1};
  MovingCollider collider(spec);
  collider.aim({velocity, Eigen::Quaterniond::Identity()}, 1);
  return collider;
}

const Vector3 up(0, 0, 1), down(0, 0, -1), still(0, 0, 0);

TEST(Pinches, RoomIsWhatBothGapsAndTheWayOfBothSurfacesLeave) {
  const auto no_room = [](double gap, double speed) {
    return Pinches::leave_no_room(contact(up, {0, 0, speed}, gap, 0),
                                  contact(down, {0, 0, -speed}, gap, 0));
  };
  EXPECT_FALSE(no_room(0.001, 0));
  EXPECT_TRUE(no_room(0, 0));
  EXPECT_FALSE(no_room(0.001, 0.09)) << "0.9 mm of each";
  EXPECT_TRUE(no_room(0.001, 0.11)) << "1.1 mm of each";
  EXPECT_FALSE(no_room(0.001, -5)) << "they part";
}

TEST(Pinches, SurfacesThatDoNotFaceEachOtherPushSideways) {
  for (const double angle : {0.0, 60.0, 100.0, 119.0, 121.0, 180.0}) {  // between normals
    const double a = angle * M_PI / 180;
    const Vector3 other(std::sin(a), 0, std::cos(a));
    EXPECT_EQ(Pinches::leave_no_room(contact(up, still, 0, 1), contact(other, still, 0, 1)),
              angle > 120)
        << angle;
  }
}

TEST(Pinches, APointGoesMidwayAcrossAndMoreWithTheRougherAlong) {
  const Cloth cloth = make_grid(chain_spec(2, 1, 0));
  const Vector3 of_floor(1, 0, 2), of_thumb(5, 0, -8);
  const auto velocity = [&](double of_floor_friction, double of_thumb_friction) {
    const ContactImpulse a = contact(up, of_floor, 0, of_floor_friction);
    const ContactImpulse b = contact(down, of_thumb, 0, of_thumb_friction);
    Pinches pinches;
    pinches.start_over(100 * h);  // a firm grip
    pinches.add(1, still, {a, moving(of_floor)}, {b, moving(of_thumb)}, cloth);
    EXPECT_TRUE(pinches.holds(1));
    EXPECT_FALSE(pinches.holds(0));
    Points velocities(2, 3);
    velocities << 7, 7, 7, 10, 20, 30;
    pinches.sweep(velocities);
    EXPECT_EQ(row(velocities, 0), Vector3(7, 7, 7));
    EXPECT_LT(pinches.sweep(velocities), 1e-12) << "held already";
    return row(velocities, 1);
  };
  EXPECT_LT((velocity(0.5, 0.5) - Vector3(3, 0, -3)).norm(), 1e-12);
  EXPECT_LT((velocity(0.3, 0.1) - Vector3(2, 0, -3)).norm(), 1e-12);
  EXPECT_LT((velocity(0, 0.1) - Vector3(5, 0, -3)).norm(), 1e-12);
  EXPECT_LT((velocity(0, 0) - Vector3(10, 20, -3)).norm(), 1e-12) << "slips";
}

TEST(Pinches, ItSticksInAWedgeBelowBothAnglesOfFriction) {
  const Cloth cloth = make_grid(chain_spec(2, 1, 0));
  for (const auto& [first, second] : {std::pair{0.3, 0.3}, {0.1, 0.5}, {0.0, 0.2}, {2.0, 2.0}}) {
    const double most = std::atan(first) + std::atan(second);
    for (const double wedge : {most - 0.01, most + 0.01}) {
      if (wedge > M_PI / 3) continue;  // wider ones are left to impulses
      const ContactImpulse a = contact(up, still, 0, first);
      const ContactImpulse b = contact({std::sin(wedge), 0, -std::cos(wedge)}, still, 0, second);
      ASSERT_TRUE(Pinches::leave_no_room(a, b));
      Pinches pinches;
      pinches.start_over(100 * h);  // a firm grip
      pinches.add(0, still, {a, moving(still)}, {b, moving(still)}, cloth);
      Points velocities = Points::Ones(2, 3);
      pinches.sweep(velocities);
      EXPECT_EQ(velocities.row(0).norm() < 1e-12, wedge < most) << first << ' ' << wedge;
    }
  }
}

TEST(Pinches, WithoutFrictionNothingSticksWhateverTheRoundings) {
  // Normals whose product is beyond 1 by a rounding.
  const Cloth cloth = make_grid(chain_spec(2, 1, 0));
  const Points directions = random_points(200, 1, 1);
  for (int k = 0; k < directions.rows(); ++k) {
    const Vector3 normal = row(directions, k).normalized();
    const ContactImpulse a = contact(normal, still, 0, 0), b = contact(-normal, still, 0, 0);
    Pinches pinches;
    pinches.start_over(h);
    pinches.add(0, still, {a, moving(still)}, {b, moving(still)}, cloth);
    Points velocities = Points::Ones(2, 3);
    pinches.sweep(velocities);
    const Vector3 along = Vector3::Ones() - normal.sum() * normal;
    EXPECT_LT((row(velocities, 0) - along).norm(), 1e-12) << k;
  }
}

TEST(Pinches, WhatIsPulledWithMoreThanItsShareOfThreeWeightsOfTheClothSlips) {
  const Cloth cloth = make_grid(chain_spec(4, 1, 0));
  const double all = 3 * 9.81 * h * cloth.mass.sum() * cloth.inv_mass[1];  // [m/s]
  const double grip = all / 2;
  const MovingCollider finger = moving(still), thumb = moving(still), other = moving(still);
  const ContactImpulse a = contact(up, still, 0, 1), b = contact(down, still, 0, 1);
  Pinches pinches;
  pinches.start_over(h);
  pinches.add(1, still, {a, finger}, {b, thumb}, cloth);
  pinches.add(2, still, {b, thumb}, {a, finger}, cloth);
  pinches.add(3, still, {a, finger}, {b, other}, cloth);  // shares with none
  // In two pulls.
  Points velocities = Points::Zero(4, 3);
  for (int pull = 0; pull < 2; ++pull) {
    velocities.row(1) += Eigen::RowVector3d(0.49 * grip, 0, 1e3);
    velocities.row(2) += Eigen::RowVector3d(0.51 * grip, 0, 1e3);
    velocities.row(3) += Eigen::RowVector3d(0.49 * all, 0, 1e3);
    pinches.sweep(velocities);
  }
  EXPECT_LT(row(velocities, 1).norm(), 1e-9 * grip);
  EXPECT_LT((row(velocities, 2) - Vector3(0.02 * grip, 0, 0)).norm(), 1e-9 * grip);
  EXPECT_LT(row(velocities, 3).norm(), 1e-9 * grip);

  // It is moved along as far as it slips, and never across.
  Points positions = Points::Constant(4, 3, 5);
  pinches.correct(Points::Zero(4, 3), positions);
  EXPECT_EQ(row(positions, 1), Vector3(0, 0, 0));
  EXPECT_EQ(row(positions, 2), Vector3(5, 5, 0));
}

TEST(Pinches, PinsAndPointsThatAreHeldAreLeftAlone) {
  Cloth cloth = make_grid(chain_spec(2, 1, 0));
  cloth.inv_mass[0] = 0;
  const ContactImpulse a = contact(up, still, 0, 1), b = contact(down, still, 0, 1);
  Pinches pinches;
  pinches.start_over(h);
  EXPECT_EQ(pinches.first(), -1);
  for (const int point : {0, 1, 1}) {
    pinches.add(point, still, {a, moving(still)}, {b, moving(still)}, cloth);
  }
  EXPECT_EQ(pinches.count(), 1);
  EXPECT_EQ(pinches.first(), 1);
  pinches.start_over(h);
  EXPECT_EQ(pinches.count(), 0);
  EXPECT_FALSE(pinches.holds(1));
}

TEST(ForEachTwo, VisitsWhatBruteForceFinds) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> key(0, 9);
  for (int round = 0; round < 20; ++round) {
    std::vector<int> keys(30);
    for (int& k : keys) k = key(random);
    std::multiset<std::pair<std::size_t, std::size_t>> expected, found;
    for (std::size_t j = 0; j < keys.size(); ++j) {
      for (std::size_t i = 0; i < j; ++i) {
        if (keys[i] == keys[j]) expected.emplace(i, j);
      }
    }
    for_each_two(
        keys.size(), 10, [&](std::size_t i) { return keys[i]; },
        [&](std::size_t i, std::size_t j) { found.emplace(i, j); });
    EXPECT_EQ(found, expected);
  }
}

}  // namespace
}  // namespace clothsim
