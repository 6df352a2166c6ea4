#include "clothsim/constraints/pinches.h"

#include <array>
#include <cmath>

#include "clothsim/model/compression.h"
#include "verification/testing.h"

namespace clothsim {
namespace {

using namespace testing;

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
  return {&collider, normal, distance, thickness / 2 + layers * thickness, layers == 0};
}

TEST(Pinches, RoomIsWhatLayersNeedAndTheWayOfBothSurfacesLeaves) {
  const auto no_room = [](double gap, double speed, int below, int above) {
    const MovingCollider a = moving({0, 0, speed}), b = moving({0, 0, -speed});
    return Pinches::room(side(a, up, 0.3 * gap, below), side(b, down, 0.7 * gap, above), still,
                         h) <= 1;
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

/// Area on which colliders press so that friction bears all that these tests do [m^2].
constexpr double wide = 1e3;

/// Velocity of a pinched point that had (10, 20, 30) m/s.
Vector3 pinched(const Pinches::ColliderDistance& a, const Pinches::ColliderDistance& b,
                double friction_of_cloth = 0.5) {
  const Cloth cloth = row_of(2, friction_of_cloth);
  Pinches pinches;
  pinches.start_over(h);
  pinches.add(1, still, a, b, wide, cloth);
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
  pinches.add(0, x, side(a, up, 0), side(b, down, 0), wide, cloth);
  Points positions = Points::Zero(2, 3), start = Points::Zero(2, 3);
  start.row(0) = x.transpose();
  pinches.project_positions(start, positions);
  EXPECT_LT((row(positions, 0) - to_world(a.pose(), to_local(a.previous(), x))).norm(), 1e-15);
}

TEST(Pinches, OuterLayersGoAlongWithTheirColliderAndInnerOnesWithNone) {
  const MovingCollider a = rough(still, 0.4), b = rough({1, 0, 0}, 0.2);
  EXPECT_NEAR(pinched(side(a, up, 0), side(b, down, 0, 1)).x(), 0, 1e-12);
  EXPECT_NEAR(pinched(side(a, up, 0, 1), side(b, down, 0)).x(), 1, 1e-12);
  EXPECT_NEAR(pinched(side(a, up, 0, 1), side(b, down, 0, 1)).x(), 10, 1e-12)
      << "layers rub on each other by their contacts";
}

TEST(Pinches, ALayerPressesByVanWyksLawOnItsArea) {
  // Two layers at half their thickness: the pressure is 7 kappa.
  Cloth cloth = row_of(4);
  cloth.compression = 2e3;
  const double area = 1e-4, normal_impulse = h * area * 7 * cloth.compression;
  const MovingCollider a = rough(still, 1), b = rough(still, 1);
  Pinches pinches;
  pinches.start_over(h);
  const double quarter = thickness / 4;
  for (const int point : {0, 1}) {
    pinches.add(point, still, side(a, up, quarter), side(b, down, 3 * quarter, 1), area, cloth);
  }
  for (const int point : {2, 3}) {
    pinches.add(point, still, side(a, up, 3 * quarter, 1), side(b, down, quarter), area, cloth);
  }
  // Each upper point touches both lower ones: half of its normal impulse in each contact.
  const auto contact = [](int above, int below) {
    return std::array<int, 4>{above, below, below, below};
  };
  const std::array<double, 4> weights{1, -1, 0, 0};
  for (const int above : {2, 3}) {
    for (const int below : {0, 1}) pinches.add_layer_contact(contact(above, below), weights, up);
  }
  EXPECT_NEAR(pinches.layer_normal_impulse(contact(2, 0), weights, up), normal_impulse / 2,
              1e-12 * normal_impulse);

  std::vector<MovingCollider> colliders = {a, b};
  Pinches pressed;
  pressed.start_over(h);
  pressed.add(0, still, side(colliders[0], up, quarter), side(colliders[1], down, 3 * quarter, 1),
              area, cloth);
  pressed.add(2, still, side(colliders[0], up, 3 * quarter, 1), side(colliders[1], down, quarter),
              area, cloth);
  std::vector<ContactLoad> loads(2);
  pressed.add_impulses(colliders, cloth, 1, Points::Zero(4, 3), loads);
  EXPECT_NEAR(loads[0].normal_force, normal_impulse, 1e-12 * normal_impulse);
  EXPECT_NEAR(loads[1].normal_force, normal_impulse, 1e-12 * normal_impulse);
  EXPECT_LT((loads[0].wrench.force + normal_impulse * up).norm(), 1e-12 * normal_impulse);
  EXPECT_LT((loads[1].wrench.force - normal_impulse * up).norm(), 1e-12 * normal_impulse);
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
                  wide, cloth);
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
    pinches.add(0, still, side(a, normal, 0), side(b, -normal, 0), wide, cloth);
    Points velocities = Points::Ones(2, 3);
    pinches.solve_pass(velocities);
    const Vector3 along = Vector3::Ones() - normal.sum() * normal;
    EXPECT_LT((row(velocities, 0) - along).norm(), 1e-12) << k;
    EXPECT_EQ(pinches.slipping(), 0) << "nothing could hold it";
  }
}

TEST(Pinches, APointSlipsByCoulombsLaw) {
  const Cloth cloth = row_of(3);
  const double area = 1e-4, gap = 0.8 * thickness;
  const double normal_force = area * compression_pressure(cloth.compression, 0.8);
  const double bound = (0.7 + 0.2) * normal_force * h * cloth.inv_mass[1];  // [m/s]
  const MovingCollider finger = rough(still, 0.7), thumb = rough(still, 0.2);
  Pinches pinches;
  pinches.start_over(h);
  for (const int point : {0, 1}) {
    pinches.add(point, still, side(finger, up, gap / 2), side(thumb, down, gap / 2), area, cloth);
  }
  Points velocities = Points::Zero(3, 3);
  velocities.row(0) << 0.99 * bound, 0, 1e3;
  velocities.row(1) << 0, 1.03 * bound, 1e3;
  pinches.solve_pass(velocities);
  EXPECT_LT(row(velocities, 0).norm(), 1e-9 * bound);
  EXPECT_LT((row(velocities, 1) - Vector3(0, 0.03 * bound, 0)).norm(), 1e-9 * bound);
  EXPECT_EQ(pinches.slipping(), 1);
  EXPECT_LT(pinches.solve_pass(velocities), 1e-9 * bound) << "slips as fast in the next pass";

  // A point is moved along by its slip, and never across.
  Points positions = Points::Constant(3, 3, 5);
  pinches.project_positions(Points::Zero(3, 3), positions);
  EXPECT_EQ(row(positions, 0), Vector3(0, 0, 0));
  EXPECT_EQ(row(positions, 1), Vector3(5, 5, 0));
}

TEST(Pinches, PinsAndPointsThatAreHeldAreLeftAlone) {
  Cloth cloth = row_of(2);
  cloth.inv_mass[0] = 0;
  const MovingCollider a = rough(still, 1), b = rough({0, 0, 0.3}, 1);
  Pinches pinches;
  pinches.start_over(h);
  EXPECT_EQ(pinches.first(), -1);
  for (const int point : {0, 1, 1}) {
    pinches.add(point, still, side(a, up, 0.001), side(b, down, 0.002), wide, cloth);
  }
  EXPECT_EQ(pinches.count(), 1);
  EXPECT_EQ(pinches.first(), 1);
  EXPECT_LT((pinches.velocity(1) - Vector3(0, 0, 0.1)).norm(), 1e-12);
  pinches.start_over(h);
  EXPECT_EQ(pinches.count(), 0);
  EXPECT_FALSE(pinches.holds(1));
}

}  // namespace
}  // namespace clothsim
