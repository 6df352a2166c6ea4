#include "clothsim/shapes/moving_collider.h"

#include <gtest/gtest.h>

#include <cmath>

namespace clothsim::moving_collider_test {
namespace {

Pose pose(const Vector3& position, double angle, const Vector3& axis) {
  return {position, Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis))};
}

ColliderSpec spec_at(const Pose& start) {
  ColliderSpec spec;
  spec.name = "ball";
  spec.pose = start;
  spec.friction = 0.4;
  return spec;
}

TEST(MovingCollider, StaysWhereItIsPlaced) {
  MovingCollider collider(spec_at(pose(Vector3(1, 2, 3), 0.5, Vector3::UnitX())));
  EXPECT_EQ(collider.friction(), 0.4);
  collider.advance(1);
  EXPECT_EQ(collider.pose().position, Vector3(1, 2, 3));
  EXPECT_EQ(collider.velocity_at(Vector3(9, 9, 9)), Vector3::Zero());
  collider.place(pose(Vector3(4, 4, 4), 0, Vector3::UnitX()));
  EXPECT_EQ(collider.previous().position, Vector3(4, 4, 4)) << "a jump is no motion";
}

TEST(MovingCollider, VelocitiesOfManyPointsAreThoseOfEach) {
  const Points points = Points::Random(20, 3);
  for (const double angle : {0.0, 0.7}) {
    MovingCollider collider(spec_at(pose(Vector3(1, 0, 0), 0.2, Vector3::UnitX())));
    collider.set_target(pose(Vector3(1, 2, -1), 0.2 + angle, Vector3::UnitX()), 0.5);
    const Points velocities = collider.velocities_at(points);
    for (int i = 0; i < 20; ++i) {
      EXPECT_NEAR((row(velocities, i) - collider.velocity_at(row(points, i))).norm(), 0, 1e-14);
    }
  }
}

TEST(MovingCollider, ArrivesAtItsTargetInEvenSteps) {
  const Pose start = pose(Vector3(1, 0, 0), 0.2, Vector3::UnitZ());
  const Pose target = pose(Vector3(1, 2, -1), 1.4, Vector3::UnitZ());
  MovingCollider collider(spec_at(start));
  collider.set_target(target, 0.5);
  for (int k = 1; k <= 5; ++k) {
    const Vector3 before = collider.pose().position;
    collider.advance(0.1);
    EXPECT_EQ(collider.previous().position, before);
    EXPECT_NEAR((collider.pose().position - Vector3(1, 0.4 * k, -0.2 * k)).norm(), 0, 1e-14);
    const Eigen::AngleAxisd turned(collider.pose().orientation * start.orientation.conjugate());
    EXPECT_NEAR(turned.angle(), 0.24 * k, 1e-12);
  }
  collider.snap_to_target();
  EXPECT_EQ(collider.pose().position, target.position);
  EXPECT_EQ(collider.pose().orientation.coeffs(), target.orientation.coeffs());
  EXPECT_EQ(collider.velocity_at(Vector3(1, 1, 1)), Vector3::Zero());
}

TEST(MovingCollider, SurfaceVelocityIsThatOfARigidBody) {
  // v = V + w x r, here V = (0, 4, -2) m/s and w = 2.4 rad/s about z.
  MovingCollider collider(spec_at(pose(Vector3(1, 0, 0), 0.2, Vector3::UnitZ())));
  collider.set_target(pose(Vector3(1, 2, -1), 1.4, Vector3::UnitZ()), 0.5);
  const Vector3 v = collider.velocity_at(Vector3(1.5, 1, 9));
  EXPECT_NEAR((v - Vector3(-2.4, 4 + 2.4 * 0.5, -2)).norm(), 0, 1e-12);
}

TEST(MovingCollider, CarriesWhatIsOnItAlong) {
  const Vector3 axis = Vector3(1, 2, 3).normalized();
  for (const double angle : {0.0, 0.4, 3.0}) {
    MovingCollider collider(spec_at(pose(Vector3(1, 0, 0), 0.2, axis)));
    collider.set_target(pose(Vector3(1, 2, -1), 0.2 + angle, axis), 1);
    collider.advance(0.5);
    const Vector3 x(0.5, 7, -3);
    const Vector3 expected = to_world(collider.pose(), to_local(collider.previous(), x));
    EXPECT_LT((collider.carried(x) - expected).norm(), 1e-14) << angle;
  }
}

TEST(MovingCollider, KnowsWhereItWasWithinTheLastStep) {
  MovingCollider collider(spec_at(pose(Vector3(1, 0, 0), 0.2, Vector3::UnitZ())));
  collider.set_target(pose(Vector3(1, 2, -1), 1.4, Vector3::UnitZ()), 1);
  collider.advance(0.5);
  EXPECT_NEAR(collider.last_turn(), 0.6, 1e-12);
  const Pose middle = collider.pose_at(0.5);
  EXPECT_NEAR((middle.position - Vector3(1, 0.5, -0.25)).norm(), 0, 1e-14);
  EXPECT_NEAR(Eigen::AngleAxisd(middle.orientation).angle(), 0.5, 1e-12);
  EXPECT_EQ(collider.pose_at(0).orientation.coeffs(), collider.previous().orientation.coeffs());
  EXPECT_LT(
      (collider.pose_at(1).orientation.coeffs() - collider.pose().orientation.coeffs()).norm(),
      1e-15);
  collider.place(middle);
  EXPECT_EQ(collider.last_turn(), 0);
}

TEST(MovingCollider, TurnsTheShortWay) {
  MovingCollider collider(spec_at(pose(Vector3::Zero(), 3.0, Vector3::UnitZ())));
  collider.set_target(pose(Vector3::Zero(), -3.0, Vector3::UnitZ()), 1);
  const double w = collider.velocity_at(Vector3::UnitX()).y();
  EXPECT_NEAR(w, 2 * M_PI - 6, 1e-12);
  // The negative of a quaternion is the same orientation: no rotation.
  Pose same = pose(Vector3::Zero(), 3.0, Vector3::UnitZ());
  same.orientation.coeffs() *= -1;
  collider.place(pose(Vector3::Zero(), 3.0, Vector3::UnitZ()));
  collider.set_target(same, 1);
  EXPECT_NEAR(collider.velocity_at(Vector3::UnitX()).norm(), 0, 1e-7);
}

TEST(MovingCollider, ReachesWhatItsShapeMayHaveTouchedOnItsWay) {
  const Eigen::AlignedBox3d box(Vector3(-0.1, -0.1, 0.9), Vector3(0.1, 0.1, 1.1));
  const auto at = [](double z) { return pose(Vector3(0, 0, z), 0, Vector3::UnitX()); };
  const auto reaches = [&](const Shape& shape, double from, double to, double margin) {
    ColliderSpec spec = spec_at(at(from));
    spec.shape = shape;
    MovingCollider collider(spec);
    collider.set_target(at(to), 1);
    collider.advance(1);
    return collider.reaches(box, margin);
  };
  // At rest, below the box by 0.4.
  EXPECT_FALSE(reaches(Plane{}, 0.5, 0.5, 0.39));
  EXPECT_TRUE(reaches(Plane{}, 0.5, 0.5, 0.41));
  EXPECT_FALSE(reaches(Sphere{0.2}, 0.5, 0.5, 0.19));
  EXPECT_TRUE(reaches(Sphere{0.2}, 0.5, 0.5, 0.21));
  EXPECT_TRUE(reaches(Plane{}, 5, 5, 0)) << "all below a plane is solid";
  EXPECT_FALSE(reaches(Plane{true}, 5, 5, 3.89));
  EXPECT_TRUE(reaches(Plane{true}, 5, 5, 3.91));
  // Past it in one step.
  EXPECT_TRUE(reaches(Plane{true}, 0, 5, 0));
  EXPECT_TRUE(reaches(Sphere{0.2}, 0, 5, 0));

  MovingCollider off(spec_at(at(1)));
  EXPECT_TRUE(off.reaches(box, 0));
  off.enable(false);
  EXPECT_FALSE(off.reaches(box, 0));
}

}  // namespace
}  // namespace clothsim::moving_collider_test
