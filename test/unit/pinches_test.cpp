#include "clothsim/constraints/pinches.h"

#include <cmath>

#include "verification/testing.h"

namespace clothsim::pinches_test {
namespace {

using namespace test;

constexpr double h = 0.01;  // [s]

/// A collider that moves at `velocity`.
MovingCollider moving(const Vector3& velocity) {
  ColliderSpec spec;
  spec.shape = Sphere{0.1};
  MovingCollider collider(spec);
  collider.set_target({velocity, Eigen::Quaterniond::Identity()}, 1);
  collider.advance(h);
  return collider;
}

const Vector3 up(0, 0, 1), down(0, 0, -1), still(0, 0, 0);
constexpr double thickness = 0.002;  // of a layer [m]

/// A cloth in a row with layers of that thickness, which rub on each other.
Cloth row_of(int points, double friction = 0.5) {
  ClothSpec spec = chain_spec(points, 1, 0);
  spec.thickness = thickness / 2;
  spec.friction = friction;
  Cloth cloth = make_grid(spec);
  cloth.offset = thickness / 2;
  return cloth;
}

MovingCollider rough(const Vector3& velocity, double friction) {
  MovingCollider collider = moving(velocity);
  collider.set_friction(friction);
  return collider;
}

/// The distance of a collider that faces `normal`, with so many layers in between.
Pinches::ColliderDistance side(const MovingCollider& collider, const Vector3& normal,
                               double distance, int layers = 0) {
  return {&collider, normal, distance, thickness / 2 + layers * thickness, layers, layers == 0};
}

TEST(Pinches, RoomIsWhatLayersNeedAndTheWayOfBothSurfacesLeaves) {
  const auto no_room = [](double gap, double speed, int below, int above) {
    const MovingCollider a = moving({0, 0, speed}), b = moving({0, 0, -speed});
    return Pinches::leave_no_room(side(a, up, 0.3 * gap, below), side(b, down, 0.7 * gap, above),
                                  still, h);
  };
  EXPECT_FALSE(no_room(0.0021, 0, 0, 0));
  EXPECT_TRUE(no_room(0.0019, 0, 0, 0));
  EXPECT_FALSE(no_room(0.004, 0.09, 0, 0)) << "0.9 mm of each";
  EXPECT_TRUE(no_room(0.004, 0.11, 0, 0)) << "1.1 mm of each";
  EXPECT_FALSE(no_room(0.001, -5, 0, 0)) << "they part";
  for (const int layers : {2, 3, 4}) {
    for (int below = 0; below < layers; ++below) {
      const double layer_height = layers * thickness;
      EXPECT_TRUE(no_room(layer_height - 1e-6, 0, below, layers - 1 - below));
      EXPECT_FALSE(no_room(layer_height + 1e-6, 0, below, layers - 1 - below));
    }
  }
}

TEST(Pinches, SurfacesThatDoNotFaceEachOtherPushSideways) {
  for (const double angle : {0.0, 60.0, 100.0, 119.0, 121.0, 180.0}) {  // between normals
    const double a = angle * M_PI / 180;
    EXPECT_EQ(Pinches::face_each_other(up, {std::sin(a), 0, std::cos(a)}), angle > 120) << angle;
  }
}

/// Velocity of a pinched point that had (10, 20, 30) m/s.
Vector3 pinched(const Pinches::ColliderDistance& a, const Pinches::ColliderDistance& b,
                double friction_of_cloth = 0.5) {
  const Cloth cloth = row_of(2, friction_of_cloth);
  Pinches pinches;
  pinches.start_over(h);
  pinches.add(1, still, a, b, cloth);
  EXPECT_TRUE(pinches.holds(1));
  EXPECT_FALSE(pinches.holds(0));
  Points velocities(2, 3);
  velocities << 7, 7, 7, 10, 20, 30;
  pinches.solve_pass(velocities);
  EXPECT_EQ(row(velocities, 0), Vector3(7, 7, 7));
  EXPECT_LT(pinches.solve_pass(velocities), 1e-12) << "held already";
  EXPECT_EQ(pinches.slipping(), 0);
  return row(velocities, 1);
}

TEST(Pinches, APointGoesAlongMoreWithTheRougher) {
  const Vector3 of_floor(1, 0, 0), of_thumb(5, 0, 0);
  const auto velocity = [&](double friction_of_floor, double friction_of_thumb) {
    const MovingCollider a = rough(of_floor, friction_of_floor),
                         b = rough(of_thumb, friction_of_thumb);
    return pinched(side(a, up, 0), side(b, down, 0));
  };
  EXPECT_LT((velocity(0.5, 0.5) - Vector3(3, 0, 0)).norm(), 1e-12);
  EXPECT_LT((velocity(0.3, 0.1) - Vector3(2, 0, 0)).norm(), 1e-12);
  EXPECT_LT((velocity(0, 0.1) - Vector3(5, 0, 0)).norm(), 1e-12);
  EXPECT_LT((velocity(0, 0) - Vector3(10, 20, 0)).norm(), 1e-12) << "slips";
}

TEST(Pinches, APointTurnsWithBothAsOneBody) {
  ColliderSpec spec;
  spec.shape = Sphere{0.1};
  spec.friction = 1;
  MovingCollider a(spec), b(spec);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.5, Vector3(1, 2, 3).normalized()));
  for (MovingCollider* collider : {&a, &b}) {
    collider->set_target({Vector3(4, 5, 6), turn}, 1);
    collider->advance(h);
  }
  const Cloth cloth = row_of(2);
  const Vector3 x(0.3, 0.2, 0.1);
  Pinches pinches;
  pinches.start_over(h);
  pinches.add(0, x, side(a, up, 0), side(b, down, 0), cloth);
  Points positions = Points::Zero(2, 3), start = Points::Zero(2, 3);
  start.row(0) = x.transpose();
  pinches.project_positions(start, positions);
  EXPECT_LT((row(positions, 0) - to_world(a.pose(), to_local(a.previous(), x))).norm(), 1e-15);
}

TEST(Pinches, LayersShareWhatSurfacesRubInARow) {
  // Each surface in the row slides in proportion to 1 / friction: jaw, layer, layer, jaw.
  const double of_jaws = 0.4, of_cloth = 0.2;
  const MovingCollider a = rough(still, of_jaws), b = rough({1, 0, 0}, of_jaws);
  const double all = 2 / of_jaws + 1 / of_cloth;
  EXPECT_NEAR(pinched(side(a, up, 0), side(b, down, 0, 1), of_cloth).x(), 1 / of_jaws / all, 1e-12);
  EXPECT_NEAR(pinched(side(a, up, 0, 1), side(b, down, 0), of_cloth).x(),
              (1 / of_jaws + 1 / of_cloth) / all, 1e-12);
  EXPECT_NEAR(pinched(side(a, up, 0, 1), side(b, down, 0), 0).x(), 1, 1e-12) << "with its own jaw";
  EXPECT_NEAR(pinched(side(a, up, 0, 1), side(b, down, 0, 1), 0).x(), 10, 1e-12)
      << "between layers that slide on it";
}

TEST(Pinches, LayersKeepTheirSharesOfAGapThatCloses) {
  const MovingCollider a = moving({0, 0, 2}), b = moving({0, 0, -8});
  for (const double share : {0.0, 0.25, 0.5, 0.9}) {
    const double gap = 0.003;
    const double rate =
        pinched(side(a, up, share * gap, 1), side(b, down, (1 - share) * gap, 1)).z();
    EXPECT_NEAR(rate, (1 - share) * 2 - share * 8, 1e-12) << share;
    const double overlap = -0.001;
    const double least =
        pinched(side(a, up, share * overlap, 1), side(b, down, (1 - share) * overlap, 1)).z();
    EXPECT_NEAR(least, -3, 1e-12) << "as thin as they get: together";
  }
}

TEST(Pinches, ItSticksInAWedgeBelowBothAnglesOfFriction) {
  const Cloth cloth = row_of(2);
  for (const auto& [first, second] : {std::pair{0.3, 0.3}, {0.1, 0.5}, {0.0, 0.2}, {2.0, 2.0}}) {
    const double most = std::atan(first) + std::atan(second);
    for (const double wedge : {most - 0.01, most + 0.01}) {
      if (wedge > M_PI / 3) continue;  // impulses handle wider ones
      const MovingCollider a = rough(still, first), b = rough(still, second);
      Pinches pinches;
      pinches.start_over(h);
      pinches.add(0, still, side(a, up, 0), side(b, {std::sin(wedge), 0, -std::cos(wedge)}, 0),
                  cloth);
      Points velocities = Points::Ones(2, 3);
      pinches.solve_pass(velocities);
      EXPECT_EQ(velocities.row(0).norm() < 1e-12, wedge < most) << first << ' ' << wedge;
    }
  }
}

TEST(Pinches, WithoutFrictionNothingSticksWhateverTheRoundings) {
  // Normals whose product exceeds 1 by a rounding.
  const Cloth cloth = row_of(2);
  const MovingCollider a = moving(still), b = moving(still);
  const Points directions = random_points(200, 1, 1);
  for (int k = 0; k < directions.rows(); ++k) {
    const Vector3 normal = row(directions, k).normalized();
    Pinches pinches;
    pinches.start_over(h);
    pinches.add(0, still, side(a, normal, 0), side(b, -normal, 0), cloth);
    Points velocities = Points::Ones(2, 3);
    pinches.solve_pass(velocities);
    const Vector3 along = Vector3::Ones() - normal.sum() * normal;
    EXPECT_LT((row(velocities, 0) - along).norm(), 1e-12) << k;
    EXPECT_EQ(pinches.slipping(), 0) << "nothing could hold it";
  }
}

TEST(Pinches, WhatTheLimitPullsWithMoreThanItsShareOfThreeWeightsOfTheClothSlips) {
  const Cloth cloth = row_of(4);
  const double all = 3 * 9.81 * h * cloth.mass.sum() * cloth.inv_mass[1];  // [m/s]
  const double grip = all / 2;
  const MovingCollider finger = rough(still, 1), thumb = rough(still, 1), other = rough(still, 1);
  Pinches pinches;
  pinches.start_over(h);
  EXPECT_NEAR(pinches.weight(cloth) * cloth.inv_mass[1], all / 3, 1e-12 * all);
  pinches.add(1, still, side(finger, up, 0), side(thumb, down, 0), cloth);
  pinches.add(2, still, side(thumb, down, 0), side(finger, up, 0), cloth);
  pinches.add(3, still, side(finger, up, 0), side(other, down, 0), cloth);  // on a pair of its own
  // The limit's pull from before they were found, and from one pass.
  Points velocities = Points::Zero(4, 3);
  Points pull = Points::Zero(4, 3);
  pull.row(1) << 0.49 * grip, 0, 1e3;
  pull.row(2) << 0.51 * grip, 0, 1e3;
  pull.row(3) << 0.49 * all, 0, 1e3;
  velocities += pull;
  pinches.set_pulls(pull);
  pinches.solve_pass(velocities);
  EXPECT_EQ(pinches.slipping(), 0);
  velocities += pull;
  pinches.add_pulls(velocities);
  pinches.solve_pass(velocities);
  EXPECT_LT(row(velocities, 1).norm(), 1e-9 * grip);
  EXPECT_LT((row(velocities, 2) - Vector3(0.02 * grip, 0, 0)).norm(), 1e-9 * grip);
  EXPECT_LT(row(velocities, 3).norm(), 1e-9 * grip);
  EXPECT_EQ(pinches.slipping(), 1);
  EXPECT_LT(pinches.solve_pass(velocities), 1e-9 * grip) << "slips as fast in the next pass";

  // A point is moved along by its slip, and never across.
  Points positions = Points::Constant(4, 3, 5);
  pinches.project_positions(Points::Zero(4, 3), positions);
  EXPECT_EQ(row(positions, 1), Vector3(0, 0, 0));
  EXPECT_EQ(row(positions, 2), Vector3(5, 5, 0));
}

TEST(Pinches, WhateverElsePushesAPointItIsHeld) {
  const Cloth cloth = row_of(2);
  const double weight = 9.81 * h * cloth.mass.sum() * cloth.inv_mass[0];  // [m/s]
  const MovingCollider finger = rough(still, 1), thumb = rough(still, 1);
  Pinches pinches;
  pinches.start_over(h);
  pinches.add(0, still, side(finger, up, 0), side(thumb, down, 0), cloth);
  Points pull = Points::Zero(2, 3);
  pull(0, 0) = 2 * weight;
  pinches.set_pulls(pull);
  Points velocities = pull;
  for (const double push : {50.0, -10.0, 1e3}) {
    velocities(0, 0) += push * weight;
    velocities(0, 1) -= push * weight;
    pinches.solve_pass(velocities);
    EXPECT_LT(row(velocities, 0).norm(), 1e-12 * push * push * weight);
    EXPECT_EQ(pinches.slipping(), 0);
  }
}

TEST(Pinches, PinsAndPointsThatAreHeldAreLeftAlone) {
  Cloth cloth = row_of(2);
  cloth.inv_mass[0] = 0;
  const MovingCollider a = rough(still, 1), b = rough({0, 0, 0.3}, 1);
  Pinches pinches;
  pinches.start_over(h);
  EXPECT_EQ(pinches.first(), -1);
  for (const int point : {0, 1, 1}) {
    pinches.add(point, still, side(a, up, 0.001), side(b, down, 0.002), cloth);
  }
  EXPECT_EQ(pinches.count(), 1);
  EXPECT_EQ(pinches.first(), 1);
  EXPECT_LT((pinches.velocity(1) - Vector3(0, 0, 0.1)).norm(), 1e-12);
  pinches.start_over(h);
  EXPECT_EQ(pinches.count(), 0);
  EXPECT_FALSE(pinches.holds(1));
}

}  // namespace
}  // namespace clothsim::pinches_test
