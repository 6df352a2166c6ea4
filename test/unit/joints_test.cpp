// Joints and parts of rigid bodies.

#include <gtest/gtest.h>

#include <cmath>

#include "bodies.h"
#include "clothsim/constraints/local_cloth.h"

namespace clothsim::joints_test {
namespace {

using namespace test;

/// A box whose centre is 0.5 m from a hinge along y at (0, 0, 1), at this angle from hanging.
ColliderSpec pendulum(double angle) {
  ColliderSpec box =
      body(Cuboid{{0.1, 0.1, 0.2}}, {0.5 * std::sin(angle), 0, 1 - 0.5 * std::cos(angle)}, 2);
  box.pose.orientation = Eigen::AngleAxisd(-angle, Vector3::UnitY());
  box.body->joint = Joint{Joint::Kind::hinge, {0, 1, 0}, {0, 0, 1}};
  return box;
}

/// Time of a quarter of a swing from `angle`, with steps of h [s].
double quarter_of_swing(double angle, double h) {
  World world({pendulum(angle)});
  double last = world.colliders[0].pose().position.x();
  for (int k = 1;; ++k) {
    world.step(h);
    const double x = world.colliders[0].pose().position.x();
    if (x <= 0) return h * (k - x / (x - last));
    last = x;
  }
}

TEST(Joints, SwingAsAPhysicalPendulum) {
  const double inertia = 2 * (0.1 * 0.1 + 0.2 * 0.2) / 12 + 2 * 0.5 * 0.5;
  const double omega = std::sqrt(2 * g * 0.5 / inertia);
  for (const double angle : {0.1, 1.0, 2.5}) {
    const double exact = std::comp_ellint_1(std::sin(angle / 2)) / omega;
    const double coarse = quarter_of_swing(angle, 2e-3) - exact;
    const double fine = quarter_of_swing(angle, 1e-3) - exact;
    EXPECT_LT(std::abs(fine), 1e-5 * exact);
    EXPECT_LT(std::abs(fine), std::abs(coarse) / 2);
  }
}

TEST(Joints, KeepTheDistanceAndTheEnergyOfAPendulum) {
  World world({pendulum(2)});
  const double inertia = 2 * (0.1 * 0.1 + 0.2 * 0.2) / 12 + 2 * 0.5 * 0.5;
  const auto energy = [&] {
    const double rate = world.bodies.motion(0).angular_velocity.y();
    return inertia * rate * rate / 2 + 2 * g * world.colliders[0].pose().position.z();
  };
  const double first = energy();
  for (int k = 0; k < 20000; ++k) {
    world.step(1e-3);
    ASSERT_NEAR(energy(), first, 1e-4 * 2 * g);
    ASSERT_NEAR((world.colliders[0].pose().position - Vector3(0, 0, 1)).norm(), 0.5, 1e-13);
  }
}

TEST(Joints, LetASliderGoAlongItsAxisAlone) {
  ColliderSpec box = body(Cuboid{{0.1, 0.1, 0.1}}, {0, 0, 1});
  box.body->joint = Joint{Joint::Kind::slider, Vector3(1, 0, 1).normalized()};
  box.body->velocity = {1, 5, 0};
  box.body->angular_velocity = {1, 2, 3};
  World world({box});
  for (int k = 0; k < 500; ++k) world.step(1e-3);
  const double way = 0.5 / std::sqrt(2) - g / std::sqrt(2) * 0.125;
  const Vector3 expected = Vector3(0, 0, 1) + way * Vector3(1, 0, 1).normalized();
  EXPECT_LT((world.colliders[0].pose().position - expected).norm(), 1e-12);
  EXPECT_TRUE(world.bodies.motion(0).angular_velocity.isZero(0));
}

TEST(Joints, EndAtTheirLimits) {
  for (const double speed : {0.0, 30.0, -30.0}) {
    ColliderSpec box = body(Cuboid{{0.1, 0.1, 0.1}}, {0, 0, 1});
    box.body->joint = Joint{Joint::Kind::slider, {0, 0, 1}, {0, 0, 0}, -0.3, 0.1};
    box.body->velocity = {0, 0, speed};
    World world({box});
    for (int k = 0; k < 1000; ++k) {
      world.step(1e-3);
      ASSERT_LE(world.colliders[0].pose().position.z(), 1.1);
      ASSERT_GE(world.colliders[0].pose().position.z(), 0.7);
    }
    EXPECT_NEAR(world.colliders[0].pose().position.z(), 0.7, 1e-12) << speed;
    EXPECT_NEAR(world.bodies.motion(0).velocity.norm(), 0, 1e-12) << speed;
  }
}

TEST(Joints, CarryStacksAtTheirLimits) {
  // A shelf at its lower limit, with a box on it.
  ColliderSpec shelf = body(Cuboid{{0.4, 0.4, 0.1}}, {0, 0, 1}, 0.1);
  shelf.body->joint = Joint{Joint::Kind::slider, {0, 0, 1}, {0, 0, 0}, 0, 1};
  World world({shelf, body(Cuboid{{0.1, 0.1, 0.1}}, {0.1, 0, 1.1}, 5)});
  for (int k = 0; k < 1000; ++k) world.step(1e-3);
  EXPECT_NEAR(world.colliders[0].pose().position.z(), 1, 1e-12);
  EXPECT_NEAR(world.colliders[1].pose().position.z(), 1.1, 1e-4);
  EXPECT_LT(world.bodies.motion(1).velocity.norm(), 1e-3);
}

TEST(Joints, HandOverMomentumAlongTheirAxis) {
  // A box slides on a drawer until both go along.
  ColliderSpec drawer = body(Cuboid{{1, 0.3, 0.1}}, {0, 0, 1}, 2, 0.5);
  drawer.body->joint = Joint{Joint::Kind::slider, {1, 0, 0}};
  ColliderSpec box = body(Cuboid{{0.1, 0.1, 0.1}}, {0, 0, 1.1}, 1, 0.5);
  box.body->velocity = {1, 0, 0};
  World world({drawer, box});
  for (int k = 0; k < 1000; ++k) {
    world.step(1e-3);
    ASSERT_NEAR(world.momentum().x(), 1, 1e-12);
  }
  EXPECT_NEAR(world.bodies.motion(0).velocity.x(), 1.0 / 3, 1e-4);
  EXPECT_NEAR(world.bodies.motion(1).velocity.x(), 1.0 / 3, 1e-4);
}

TEST(Joints, HandOverAngularMomentumAboutTheirAxis) {
  // A ball hits a door.
  ColliderSpec door = body(Cuboid{{0.8, 0.04, 1}}, {0.4, 0, 0}, 5);
  door.body->joint = Joint{Joint::Kind::hinge, {0, 0, 1}, {0, 0, 0}};
  ColliderSpec ball = body(Sphere{0.05}, {0.7, -0.2, 0}, 0.5);
  ball.body->velocity = {0, 3, 0};
  World world({door, ball});
  const double inertia = 5 * (0.8 * 0.8 + 0.04 * 0.04) / 12 + 5 * 0.4 * 0.4;
  for (int k = 0; k < 300; ++k) {
    world.step(1e-3, {0, 0, 0});
    const Vector3 arm = world.colliders[1].pose().position;
    const double of_ball = 0.5 * arm.cross(world.bodies.motion(1).velocity).z();
    ASSERT_NEAR(inertia * world.bodies.motion(0).angular_velocity.z() + of_ball, 1.05, 1e-3);
  }
  EXPECT_GT(world.bodies.motion(0).angular_velocity.z(), 0.5);
}

TEST(Joints, LeaveOutContactWithTheirRod) {
  ColliderSpec rod;
  rod.name = "rod";
  rod.shape = Capsule{2, 0.02};
  rod.pose.orientation = Eigen::AngleAxisd(M_PI / 2, Vector3::UnitY());
  ColliderSpec ring = body(Cylinder{0.02, 0.05}, {-0.5, 0, 0}, 0.1);
  ring.pose.orientation = rod.pose.orientation;
  ring.body->joint = Joint{Joint::Kind::slider, {1, 0, 0}};
  ring.body->velocity = {1, 0, 0};
  ColliderSpec stop;
  stop.name = "stop";
  stop.shape = Cuboid{{0.1, 0.1, 0.1}};
  stop.pose.position = {0.5, 0, 0};
  World world({rod, ring, stop});
  for (int k = 0; k < 500; ++k) world.step(1e-3);
  EXPECT_NEAR(world.colliders[1].pose().position.x(), 0, 1e-9);
  for (int k = 0; k < 1000; ++k) world.step(1e-3);
  EXPECT_NEAR(world.colliders[1].pose().position.x(), 0.44, 1e-3);  // it has met the stop
}

TEST(Joints, KnowTheirDistanceFromAPose) {
  World world({pendulum(0)});
  const Pose start = world.colliders[0].pose();
  EXPECT_EQ(world.bodies.distance_from_joint(0, start), 0);
  EXPECT_NEAR(world.bodies.distance_from_joint(0, {{0.1, 0, 0.5}, start.orientation}), 0.1, 1e-12);
  const ColliderSpec elsewhere = pendulum(2);
  EXPECT_LT(world.bodies.distance_from_joint(0, elsewhere.pose), 1e-12);
  EXPECT_EQ(World({body(Sphere{0.1}, {0, 0, 0})}).bodies.distance_from_joint(0, start), 0);
}

TEST(Joints, AllowNoPoseBeyondTheirLimits) {
  ColliderSpec box = pendulum(0);
  box.body->joint->lower = 0;
  box.body->joint->upper = 4;
  World world({box});
  const auto at = [&](double angle) { return pendulum(-angle).pose; };  // by y, as the joint
  EXPECT_LT(world.bodies.distance_from_joint(0, at(3.5)), 1e-12);       // a turn of -2.78, too
  EXPECT_GT(world.bodies.distance_from_joint(0, at(-1)), 0.5);
  world.colliders[0].place(at(3.5));
  world.bodies.set_velocity(0, {0, 0, 0}, {0, 0, 0}, world.colliders);
  world.step(1e-4);
  EXPECT_LT((world.colliders[0].pose().position - at(3.5).position).norm(), 1e-6);
}

/// A hammer of two boxes that falls on the ground.
std::vector<ColliderSpec> hammer() {
  ColliderSpec shaft = body(Cuboid{{0.05, 0.05, 0.4}}, {0, 0, 0.5}, 1);
  shaft.body->center_of_mass = Vector3(0, 0, 0.1);
  shaft.body->inertia = Vector3(0.02, 0.02, 0.004).asDiagonal();
  shaft.body->angular_velocity = {1, 2, 3};
  ColliderSpec head;
  head.name = "head";
  head.shape = Cuboid{{0.3, 0.1, 0.1}};
  head.pose.position = {0, 0, 0.7};
  head.friction = 0.4;
  head.part_of = "body";
  ColliderSpec ground;
  ground.name = "ground";
  ground.shape = Plane{};
  ground.friction = 0.4;
  return {shaft, head, ground};
}

TEST(Parts, MoveAsOneBody) {
  World world(hammer());
  for (int k = 0; k < 3000; ++k) {
    world.step(1e-3);
    const Pose &shaft = world.colliders[0].pose(), &head = world.colliders[1].pose();
    ASSERT_LT((to_local(shaft, head.position) - Vector3(0, 0, 0.2)).norm(), 1e-12);
    ASSERT_LT(shaft.orientation.angularDistance(head.orientation), 1e-7);
  }
  // It lies on the edge of its head and the end of its shaft.
  EXPECT_LT(world.bodies.motion(1).velocity.norm(), 1e-3);
  EXPECT_NEAR(world.colliders[1].pose().position.z(), 0.05, 0.02);
  EXPECT_GT(world.colliders[0].pose().position.z(), 0.02);
}

TEST(Parts, HaveTheMassOfTheirBody) {
  std::vector<ColliderSpec> specs = hammer();
  specs[0].body->angular_velocity.setZero();
  ColliderSpec ball = body(Sphere{0.05}, {0, -1, 0.7}, 0.5);
  ball.name = "ball";
  ball.body->velocity = {0, 5, 0};
  specs[2] = ball;
  World world(specs);
  for (int k = 0; k < 300; ++k) world.step(1e-3, {0, 0, 0});
  EXPECT_NEAR(world.momentum().y(), 2.5, 1e-12);
  EXPECT_GT(world.bodies.motion(0).velocity.y(), 1);
}

}  // namespace
}  // namespace clothsim::joints_test
