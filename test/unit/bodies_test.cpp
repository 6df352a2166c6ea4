#include "bodies.h"

#include <gtest/gtest.h>

#include <cmath>

#include "clothsim/constraints/local_cloth.h"
#include "meshes.h"

namespace clothsim::bodies_test {
namespace {

using namespace test;

/// A plane through the origin that falls towards +x at this angle [rad].
ColliderSpec slope(double angle, double friction = 0.4) {
  ColliderSpec spec;
  spec.shape = Plane{};
  spec.pose.orientation = Eigen::AngleAxisd(angle, Vector3::UnitY());
  spec.friction = friction;
  return spec;
}

TEST(RigidBodies, FallExactly) {
  ColliderSpec ball = body(Sphere{0.1}, {0, 0, 1});
  ball.body->velocity = {1, 0, 2};
  World world({ball});
  for (int k = 0; k < 50; ++k) world.step(0.01);
  const Vector3 expected(0.5, 0, 1 + 2 * 0.5 - g * 0.25 / 2);
  EXPECT_LT((world.colliders[0].pose().position - expected).norm(), 1e-13);
  EXPECT_NEAR(world.bodies.motion(0).velocity.z(), 2 - g * 0.5, 1e-13);
}

TEST(RigidBodies, LoseVelocityToAir) {
  ColliderSpec ball = body(Sphere{0.1}, {0, 0, 1});
  ball.body->velocity = {1, 0, 0};
  ball.body->damping = 2;
  World world({ball});
  for (int k = 0; k < 50; ++k) world.step(0.01, {0, 0, 0});
  EXPECT_NEAR(world.bodies.motion(0).velocity.x(), std::exp(-1), 1e-12);
}

/// Largest change of a tumbling box's energy, as a share, with steps of h [s].
double energy_error(double h) {
  ColliderSpec box = body(Cuboid{{0.1, 0.2, 0.4}}, {0, 0, 0});
  box.body->angular_velocity = {0.1, 7, 0.1};  // about the middle axis: not stable
  World world({box});
  const Matrix3 inertia = Vector3(0.04 + 0.16, 0.01 + 0.16, 0.01 + 0.04).asDiagonal() * (1.0 / 12);
  const auto in_world = [&] {
    const Matrix3 turn = world.colliders[0].pose().orientation.toRotationMatrix();
    return Matrix3(turn * inertia * turn.transpose());
  };
  const auto spin = [&] { return world.bodies.motion(0).angular_velocity; };
  const Vector3 momentum = in_world() * spin();
  const double energy = spin().dot(momentum) / 2;
  double worst = 0;
  for (int k = 0; k < std::lround(3 / h); ++k) {
    world.step(h);
    EXPECT_LT((in_world() * spin() - momentum).norm(), 1e-11 * momentum.norm());
    worst = std::max(worst, std::abs(spin().dot(momentum) / 2 / energy - 1));
  }
  return worst;
}

TEST(RigidBodies, TumbleWithTheirAngularMomentum) {
  const double coarse = energy_error(4e-3), fine = energy_error(2e-3);
  EXPECT_LT(fine, 1e-3);
  EXPECT_NEAR(coarse / fine, 4, 0.5);  // second order
}

TEST(RigidBodies, SlideByCoulombsLaw) {
  // Both friction coefficients count with their geometric mean.
  const double angle = 0.5, friction = std::sqrt(0.4 * 0.1);
  const Vector3 down(std::cos(angle), 0, -std::sin(angle));
  const Vector3 up(std::sin(angle), 0, std::cos(angle));
  ColliderSpec box = body(Cuboid{{0.2, 0.2, 0.1}}, 0.05 * up, 3, 0.1);
  box.pose.orientation = Eigen::AngleAxisd(angle, Vector3::UnitY());
  World world({slope(angle), box});
  for (int k = 0; k < 500; ++k) world.step(1e-3);
  const double expected = g * (std::sin(angle) - friction * std::cos(angle)) * 0.5;
  EXPECT_NEAR(world.bodies.motion(1).velocity.dot(down), expected, 1e-3 * expected);

  box.friction = 1.5;  // sqrt(0.4 * 1.5) > tan(0.5): the box sticks
  World rough({slope(angle), box});
  for (int k = 0; k < 500; ++k) rough.step(1e-3);
  EXPECT_LT((rough.colliders[1].pose().position - 0.05 * up).norm(), 1e-5);
}

TEST(RigidBodies, RollWithoutSliding) {
  const double angle = 0.3, radius = 0.1;
  const Vector3 down(std::cos(angle), 0, -std::sin(angle));
  const Vector3 up(std::sin(angle), 0, std::cos(angle));
  World world({slope(angle, 1), body(Sphere{radius}, radius * up, 2, 1)});
  for (int k = 0; k < 500; ++k) world.step(1e-3);
  const double expected = 5.0 / 7 * g * std::sin(angle) * 0.5;
  const RigidMotion& ball = world.bodies.motion(1);
  EXPECT_NEAR(ball.velocity.dot(down), expected, 2e-3 * expected);
  EXPECT_NEAR(ball.angular_velocity.y() * radius, expected, 2e-3 * expected);
}

TEST(RigidBodies, HandOverTheirMomentum) {
  ColliderSpec fast = body(Sphere{0.1}, {0, 0, 0}, 2);
  fast.body->velocity = {3, 0.4, 0};
  ColliderSpec box = body(Cuboid{{0.2, 0.2, 0.2}}, {0.5, 0, 0.05}, 5);
  box.body->angular_velocity = {0, 0, 2};
  World world({fast, box});
  const Vector3 momentum = world.momentum();
  for (int k = 0; k < 300; ++k) {
    world.step(1e-3, {0, 0, 0});
    ASSERT_LT((world.momentum() - momentum).norm(), 1e-13);
  }
  EXPECT_GT(world.bodies.motion(1).velocity.x(), 0.5);  // they have met
  const double gap = (world.bodies.motion(1).velocity - world.bodies.motion(0).velocity).x();
  EXPECT_GT(gap, -1e-3);
}

TEST(RigidBodies, StandInAStack) {
  std::vector<ColliderSpec> specs = {slope(0)};
  for (int k = 0; k < 5; ++k) {
    specs.push_back(body(Cuboid{{0.2 - 0.01 * k, 0.2 - 0.01 * k, 0.1}},
                         {0.002 * k, 0, 0.05 + 0.1 * k}, k % 2 ? 3 : 1));
  }
  World world(specs);
  for (int k = 0; k < 4000; ++k) world.step(5e-4);
  for (int k = 1; k <= 5; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const Vector3 way = world.colliders[i].pose().position - specs[i].pose.position;
    EXPECT_LT(way.norm(), 1e-3) << k;
    EXPECT_LT(world.bodies.motion(i).velocity.norm(), 1e-3) << k;
  }
}

TEST(RigidBodies, CarryThoseThatTheyTouch) {
  const auto at = [](double z, double mass) { return body(Sphere{0.1}, {0, 0, z}, mass); };
  World world({slope(0), at(0.1, 1), at(0.3, 2), at(2, 40)});
  world.step(1e-3);
  EXPECT_EQ(world.bodies.mass_touching(1, 0), 3);
  EXPECT_EQ(world.bodies.mass_touching(0, 2), 3);
  EXPECT_EQ(world.bodies.mass_touching(3, 0), 40);
  world.bodies.touch(2, 3);  // through cloth
  EXPECT_EQ(world.bodies.mass_touching(1, 0), 43);
  world.step(1e-3);
  EXPECT_EQ(world.bodies.mass_touching(1, 0), 43) << "those of the last step count";
  world.step(1e-3);
  EXPECT_EQ(world.bodies.mass_touching(1, 0), 3);
}

TEST(RigidBodies, LieAcrossTheEdgeOfATable) {
  ColliderSpec table;
  table.name = "table";
  table.shape = Cuboid{{1, 1, 0.2}};
  table.pose.position = {-0.5, 0, -0.1};
  for (const Shape& shape : {Shape(Capsule{0.4, 0.05}), Shape(Cylinder{0.4, 0.05})}) {
    ColliderSpec bar = body(shape, {-0.05, 0, 0.0501});  // its centre is above the table
    bar.pose.orientation = Eigen::AngleAxisd(M_PI / 2, Vector3::UnitY());
    World world({table, bar});
    for (int k = 0; k < 1000; ++k) world.step(2e-3);
    EXPECT_NEAR(world.colliders[1].pose().position.z(), 0.05, 1e-3);
    EXPECT_LT(world.bodies.motion(1).velocity.norm(), 0.01);
  }
}

TEST(RigidBodies, ContinueFromTheirMemory) {
  ColliderSpec box = body(Cuboid{{0.2, 0.2, 0.1}}, {0, 0, 0.06});
  box.body->velocity = {0.5, 0.1, 0};
  World world({slope(0), box});
  for (int k = 0; k < 60; ++k) world.step(1e-3);
  MemoryWriter writer;
  world.bodies.write(writer);
  world.contacts.write(writer);
  World other({slope(0), box});
  other.colliders = world.colliders;
  const std::vector<double> numbers = writer.numbers();
  MemoryReader reader(numbers);
  other.bodies.read(reader);
  other.contacts.read(reader, 2);
  reader.finish();
  for (int k = 0; k < 60; ++k) {
    world.step(1e-3);
    other.step(1e-3);
  }
  EXPECT_EQ(world.colliders[1].pose().position, other.colliders[1].pose().position);
  EXPECT_EQ(world.bodies.motion(1).velocity, other.bodies.motion(1).velocity);
}

/// The least gap that is found, and the number of places.
std::pair<double, std::size_t> least_gap(const Shape& a, const Pose& at, const Shape& b) {
  std::vector<ColliderSpec> specs(2);
  specs[0].shape = a;
  specs[0].pose = at;
  specs[1].shape = b;
  std::vector<MovingCollider> colliders;
  for (const ColliderSpec& spec : specs) colliders.emplace_back(spec);
  BodyCollisions collisions(colliders, {1, 0});
  double least = 1;
  const std::vector<BodyTouch> places =
      collisions.find(colliders, 2e-3, [](std::size_t, std::size_t) { return true; });
  for (const BodyTouch& t : places) least = std::min(least, t.gap);
  return {least, places.size()};
}

TEST(BodyCollisions, PaddingCounts) {
  const Shape cube = mesh_shape(box_soup({0.2, 0.2, 0.2}), 0.01);
  EXPECT_NEAR(least_gap(Sphere{0.1}, {Vector3(0, 0, 0.2105)}, cube).first, 5e-4, 1e-9);
  EXPECT_NEAR(least_gap(cube, {Vector3(0, 0, 0.1105)}, Plane{}).first, 5e-4, 1e-9);
  EXPECT_NEAR(least_gap(cube, {Vector3(0, 0, 0.1605)}, Cuboid{{1, 1, 0.1}}).first, 5e-4,
              penetration_slop);
}

TEST(RigidBodies, RestOnTheirSide) {
  ColliderSpec table;
  table.shape = Cuboid{{1, 1, 0.2}};
  table.pose.position.z() = -0.1;
  table.friction = 0.5;
  for (const Shape& shape : {Shape(Capsule{0.2, 0.1}), Shape(Cylinder{0.2, 0.1})}) {
    ColliderSpec lying = body(shape, {0.03, 0.02, 0.101});
    lying.pose.orientation = Eigen::AngleAxisd(M_PI / 2, Vector3::UnitY());
    World world({table, lying});
    for (int k = 0; k < 2000; ++k) world.step(1e-3);
    const Vector3 way = world.colliders[1].pose().position - Vector3(0.03, 0.02, 0.1);
    EXPECT_LT(way.norm(), 1e-4) << shape.index();
    EXPECT_LT(world.bodies.motion(1).velocity.norm(), 1e-4) << shape.index();
  }
}

TEST(BodyCollisions, GapsAreThoseOfTheShapes) {
  const std::vector<std::pair<Shape, double>> standing = {{Sphere{0.1}, 0.1},
                                                          {Cuboid{{0.2, 0.3, 0.1}}, 0.05},
                                                          {Cylinder{0.3, 0.1}, 0.15},
                                                          {Capsule{0.2, 0.05}, 0.15}};
  const std::vector<std::pair<Shape, double>> under = {
      {Plane{}, 0}, {Cuboid{{1, 1, 0.2}}, 0.1}, {Cylinder{0.2, 0.5}, 0.1}};
  for (const auto& [a, half] : standing) {
    for (const auto& [b, top] : under) {
      for (const double gap : {-1e-4, -1e-6, 0.0, 1e-6, 1e-4, 1e-3}) {
        SCOPED_TRACE(std::to_string(a.index()) + " on " + std::to_string(b.index()) + " at " +
                     std::to_string(gap));
        const auto [least, count] = least_gap(a, {Vector3(0.02, 0.01, top + half + gap)}, b);
        EXPECT_NEAR(least, gap, 2e-6);
        if (std::holds_alternative<Cuboid>(a) && gap < penetration_slop) {
          EXPECT_GE(count, 3u);
        }
      }
      EXPECT_EQ(least_gap(a, {Vector3(0, 0, top + half + 3e-3)}, b).second, 0u);
    }
  }
}

}  // namespace
}  // namespace clothsim::bodies_test
