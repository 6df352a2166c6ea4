#include "clothsim/constraints/contact_coupling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace clothsim::contact_coupling_test {
namespace {

/// A point at rest on the ground, under a body that comes down.
struct UnderABody {
  double mass = 1e-4;  // of the point [kg]
  RigidMotion ground;
  RigidMotion body;
  ContactCoupling coupling;

  UnderABody() {
    body.is_body = true;
    body.least_inv_mass = 1 / 50.0;
    body.inv_mass = body.least_inv_mass * Matrix3::Identity();
    body.inv_inertia = 2 * Matrix3::Identity();
    body.center = {0, 0, 0.3};
    body.velocity = {0.2, 0, -1};
    coupling.of_a.normal = {0, 0, -1};
    coupling.of_a.friction = 0.5;
    coupling.count = 1;
    coupling.corners[0] = {1, mass, {0, 0, 0}, {}, {0, 0, 0}};
    coupling.corners[0].of_b.friction = 0.8;
  }

  Vector3 momentum() const {
    const ContactCoupling::Corner& c = coupling.corners[0];
    // What the ground takes has no velocity: by its impulse.
    return body.velocity / body.least_inv_mass + c.mass * c.velocity - c.mass * c.of_b.total();
  }
};

TEST(ContactCoupling, StopsAHeavyBodyInOneUpdate) {
  UnderABody scene;
  scene.body.velocity.x() = 0;
  const Vector3 momentum = scene.momentum();
  EXPECT_NEAR(scene.coupling.update(scene.body, scene.ground), 1, 1e-12);
  EXPECT_LT(scene.body.velocity_at({0, 0, 0}).norm(), 1e-12);
  EXPECT_LT(scene.coupling.corners[0].velocity.norm(), 1e-12);
  EXPECT_NEAR(scene.coupling.of_a.normal_impulse, 50, 1e-9);  // all of its momentum
  EXPECT_NEAR(scene.coupling.corners[0].of_b.normal_impulse * scene.mass, 50, 1e-9);
  EXPECT_LT((scene.momentum() - momentum).norm(), 1e-12 * momentum.norm());
}

TEST(ContactCoupling, StopsSlidingWhereFrictionSuffices) {
  UnderABody rough;
  for (int pass = 0; pass < 60; ++pass) rough.coupling.update(rough.body, rough.ground);
  EXPECT_LT(rough.body.velocity_at({0, 0, 0}).norm(), 1e-9);

  UnderABody smooth;
  smooth.coupling.of_a.friction = 1e-3;
  for (int pass = 0; pass < 60; ++pass) smooth.coupling.update(smooth.body, smooth.ground);
  const ContactImpulse& own = smooth.coupling.of_a;
  EXPECT_LE(own.friction_impulse.norm(), 1e-3 * own.normal_impulse * (1 + 1e-9));
  EXPECT_LT(std::abs(smooth.body.velocity_at({0, 0, 0}).z()), 1e-9);
  EXPECT_GT(smooth.body.velocity_at({0, 0, 0}).x(), 0.1);
}

TEST(ContactCoupling, StaysInTheConesAndKeepsMomentum) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> one(-1, 1);
  const auto any = [&] { return Vector3(one(random), one(random), one(random)); };
  for (int seed = 0; seed < 200; ++seed) {
    UnderABody scene;
    ContactCoupling& c = scene.coupling;
    scene.body.velocity = any();
    scene.body.angular_velocity = any();
    c.of_a.normal = (Vector3(0, 0, -1) + 0.4 * any()).normalized();
    c.of_a.friction = std::abs(one(random));
    c.of_a.target_velocity = -std::abs(one(random)) / 10;
    c.count = 1 + seed % 3;
    for (std::size_t k = 0; k < c.count; ++k) {
      c.corners[k] = {1.0 / static_cast<double>(c.count), scene.mass, 0.01 * any(), {}, any() / 10};
      c.corners[k].of_b.normal = (Vector3(0, 0, 1) + 0.4 * any()).normalized();
      c.corners[k].of_b.friction = std::abs(one(random));
    }
    const auto momentum = [&] {
      Vector3 sum = scene.body.velocity / scene.body.least_inv_mass;
      for (std::size_t k = 0; k < c.count; ++k) {
        sum += c.corners[k].mass * (c.corners[k].velocity - c.corners[k].of_b.total());
      }
      return sum;
    };
    const auto is_within = [](const ContactImpulse& i) {
      return i.normal_impulse >= 0 &&
             i.friction_impulse.norm() <=
                 i.friction * i.normal_impulse * (1 + 1e-6) + 1e-9 * (1 + i.normal_impulse);
    };
    const Vector3 before = momentum();
    for (int pass = 0; pass < 40; ++pass) {
      c.update(scene.body, scene.ground);
      ASSERT_TRUE(is_within(c.of_a)) << "seed " << seed << ", pass " << pass;
      for (std::size_t k = 0; k < c.count; ++k) ASSERT_TRUE(is_within(c.corners[k].of_b));
    }
    EXPECT_LT((momentum() - before).norm(), 1e-10) << "seed " << seed;
  }
}

TEST(ContactCoupling, LetsABodyGo) {
  UnderABody scene;
  for (int pass = 0; pass < 5; ++pass) scene.coupling.update(scene.body, scene.ground);
  scene.body.velocity.z() += 3;  // as another impulse lifts it
  for (int pass = 0; pass < 5; ++pass) scene.coupling.update(scene.body, scene.ground);
  EXPECT_GE(scene.coupling.of_a.normal_impulse, 0);
  EXPECT_LT(scene.body.velocity_at({0, 0, 0}).z(), 3);
  EXPECT_GE(scene.body.velocity_at({0, 0, 0}).z(), -1e-12);
}

}  // namespace
}  // namespace clothsim::contact_coupling_test
