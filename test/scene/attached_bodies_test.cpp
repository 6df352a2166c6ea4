// Points of the cloth on rigid bodies, and bodies that a tf frame holds.

#include <cmath>

#include "bodies.h"
#include "verification/testing.h"

namespace clothsim::attached_bodies_test {
namespace {

using namespace test;

/// A strip of cloth whose lower edge is attached to a box of this mass [kg].
Scene hanging(double mass, bool is_pinned = true) {
  Scene scene;
  scene.cloth = square_spec(9, 1000);
  scene.cloth.width = 0.2;
  scene.cloth.height = 0.4;
  scene.cloth.orientation = Orientation::vertical;
  scene.cloth.origin = {-0.1, 0, 1};
  scene.cloth.material.density = 0.3;
  scene.cloth.material.damping = 3;
  BodyPoints attached{"body", {}};
  for (int column = 0; column < 9; ++column) {
    attached.points.push_back({column, 0});
    if (is_pinned) scene.cloth.pinned.push_back({column, 8, ""});
  }
  scene.cloth.attached = {attached};
  scene.colliders = {body(Cuboid{{0.24, 0.1, 0.1}}, {0, 0, 0.94}, mass)};
  scene.colliders[0].body->damping = 1;
  return scene;
}

TEST(AttachedBodies, HangOnTheCloth) {
  for (const double mass : {0.001, 0.1, 10.0}) {
    SCOPED_TRACE(mass);
    const Scene scene = hanging(mass);
    Simulator simulator(scene);
    run(simulator, mass > 1 ? 12 : 6);
    const Grip& grip = simulator.grips().at("body");
    EXPECT_NEAR(grip.wrench.force.z(), mass * g, 0.02 * mass * g);
    EXPECT_LT(grip.lag, 1e-12);
    double pull = 0;
    for (const HolderReport& pin : simulator.holders()) pull += pin.force;
    EXPECT_GT(pull, 0.98 * (mass + simulator.cloth().mass.sum()) * g);
    EXPECT_LT(simulator.body_motion(0).velocity.norm(), 0.02);
  }
}

TEST(AttachedBodies, KeepTheMomentumOfBoth) {
  for (const char* method : {"verlet", "symplectic_euler", "implicit_euler", "xpbd"}) {
    SCOPED_TRACE(method);
    Scene scene = hanging(0.05, false);
    scene.cloth.material.damping = 0;
    scene.colliders[0].body->damping = 0;
    scene.colliders[0].body->velocity = {0.3, 1, 0};
    scene.colliders[0].body->angular_velocity = {2, 0, 3};
    scene.simulation.gravity.setZero();
    scene.simulation.method = method;
    Simulator simulator(scene);
    const auto momentum = [&] {
      return Vector3(
          (simulator.cloth().mass.matrix().transpose() * simulator.state().velocities.matrix())
              .transpose() +
          0.05 * simulator.body_motion(0).velocity);
    };
    const Vector3 first = momentum();
    run(simulator, 0.5);
    EXPECT_LT((momentum() - first).norm(), 1e-9 * first.norm());
  }
}

TEST(AttachedBodies, LeaveNoEnergyInLightCloth) {
  Scene scene = hanging(0.05, false);
  scene.cloth.material.damping = 0;
  scene.colliders[0].body->damping = 0;
  scene.colliders[0].body->angular_velocity = {2, 0, 3};
  scene.simulation.gravity.setZero();
  Simulator simulator(scene);
  const auto fastest = [&] { return simulator.state().velocities.rowwise().norm().maxCoeff(); };
  double bound = 0;
  for (int k = 0; k < 900; ++k) {
    simulator.step();
    if (k < 90) bound = std::max(bound, fastest());
    ASSERT_LT(fastest(), 1.5 * bound) << k;
  }
}

TEST(AttachedBodies, HangStillHoweverLightOrSmall) {
  for (const auto& [size, share] : {std::pair(0.2, 1e-3), {0.05, 1e-3}, {0.02, 1e-4}}) {
    SCOPED_TRACE(size);
    Scene scene;
    scene.cloth = square_spec(18, 1000);
    scene.cloth.orientation = Orientation::vertical;
    scene.cloth.origin = {0, 0, 1.2};
    scene.cloth.material.density = 0.2;
    scene.cloth.material.damping = 1;
    scene.cloth.pinned = {{0, 17, ""}, {17, 17, ""}};
    BodyPoints attached{"body", {}};
    for (int column = 0; column < 18; ++column) attached.points.push_back({column, 0});
    scene.cloth.attached = {attached};
    scene.colliders = {
        body(Cuboid{Vector3::Constant(size)}, {0.5, 0, 1.19 - size / 2}, 0.2 * share)};
    Simulator simulator(scene);
    for (int k = 0; k < 90; ++k) {
      simulator.step();
      ASSERT_LT(simulator.state().velocities.rowwise().norm().maxCoeff(), 3) << k;
      ASSERT_LT(simulator.body_motion(0).velocity.norm(), 3) << k;
    }
  }
}

TEST(AttachedBodies, TearOffBeyondTheirForce) {
  Scene scene = hanging(1);
  scene.cloth.attached[0].tear_force = 5;
  Simulator simulator(scene);
  run(simulator, 1);
  EXPECT_TRUE(simulator.grips().empty());
  EXPECT_LT(simulator.body_motion(0).pose.position.z(), -1);
}

TEST(AttachedBodies, ContinueFromASavedState) {
  Simulator simulator(hanging(0.1));
  run(simulator, 0.3);
  const auto saved = simulator.save();
  const auto after = [&] {
    run(simulator, 0.3);
    return std::pair(simulator.state().positions, simulator.body_motion(0).pose.position);
  };
  const auto expected = after();
  simulator.restore(*saved);
  EXPECT_EQ(after(), expected);
  simulator.reset();
  EXPECT_EQ(simulator.grips().size(), 1u);
}

TEST(AttachedBodies, AreRefusedWhereTheSceneHasNone) {
  const auto message = [](const Scene& scene) {
    try {
      Simulator simulator(scene);
    } catch (const InvalidValue& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  Scene scene = hanging(1);
  scene.cloth.attached[0].body = "bodi";
  EXPECT_NE(message(scene).find("cloth.attached.0.body: got \"bodi\""), std::string::npos);
  scene = hanging(1);
  scene.cloth.attached[0].points.push_back({0, 8});
  EXPECT_NE(message(scene).find("cloth.attached.0.points.9: got [0, 8]"), std::string::npos);
  scene = hanging(1);
  scene.cloth.attached[0].points[2] = {9, 0};
  EXPECT_NE(message(scene).find("points.2: got [9, 0]"), std::string::npos);

  Simulator simulator(hanging(1));
  EXPECT_THROW(simulator.attach("hand", {}, {0}), InvalidValue);              // attached already
  EXPECT_THROW(simulator.attach("body", {}, {40}, {{}, 3.0}), InvalidValue);  // a strength
  EXPECT_THROW(simulator.move_grip("body", {}), InvalidValue);
  EXPECT_NO_THROW(simulator.attach("body", {}, {40}));
  EXPECT_EQ(simulator.grips().at("body").held.size(), 10u);
}

TEST(HeldBodies, FollowTheirFrameAndKeepItsVelocity) {
  Scene scene = hanging(0.2);
  scene.cloth.attached.clear();
  Simulator simulator(scene);
  simulator.attach_body(0, "hand", {Vector3(1, 0, 0)});
  EXPECT_EQ(simulator.frame_of_body(0), "hand");
  const double dt = simulator.frame_duration();
  for (int k = 1; k <= 45; ++k) {
    simulator.move_grip("hand", {Vector3(1, -0.02 * k, 0)});
    simulator.step();
    const Vector3 expected(0, -0.02 * k, 0.94);
    ASSERT_LT((simulator.body_motion(0).pose.position - expected).norm(), 1e-12);
    ASSERT_LT((simulator.body_motion(0).velocity - Vector3(0, -0.02 / dt, 0)).norm(), 1e-9);
  }
  EXPECT_THROW(simulator.attach_body(0, "other", {}), InvalidValue);
  EXPECT_THROW(simulator.set_body(0, {}, {0, 0, 0}, {0, 0, 0}), InvalidValue);
  simulator.detach_body(0);
  EXPECT_TRUE(simulator.grips().empty());
  EXPECT_THROW(simulator.detach_body(0), InvalidValue);
  for (int k = 0; k < 9; ++k) simulator.step();
  const double t = 9 * dt, way = (1 - std::exp(-t)) * 0.02 / dt;  // the air takes 1 / s
  EXPECT_NEAR(simulator.body_motion(0).pose.position.y(), -0.9 - way, 1e-3);
  EXPECT_NEAR(simulator.body_motion(0).pose.position.z(), 0.94 - g * t * t / 2, 3e-3);
}

TEST(HeldBodies, KeepTheirVelocityThroughASavedState) {
  Scene scene = hanging(0.2);
  scene.cloth.attached.clear();
  Simulator simulator(scene);
  simulator.attach_body(0, "hand", {});
  for (int k = 1; k <= 10; ++k) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.05 * k, Vector3::UnitY()));
    simulator.move_grip("hand", {Vector3(0, -0.3 * k, 0), turn});
    simulator.step();
  }
  const auto saved = simulator.save();
  const BodyMotion motion = simulator.body_motion(0);
  Simulator other(scene);
  other.restore(*saved);
  EXPECT_LT((other.body_motion(0).velocity - motion.velocity).norm(), 1e-9);
  for (Simulator* each : {&simulator, &other}) {
    each->detach_body(0);
    each->step();
  }
  EXPECT_EQ(simulator.body_motion(0).pose.position, other.body_motion(0).pose.position);
}

TEST(HeldBodies, StayOnTheirJoint) {
  Simulator simulator(shipped_scene("rings"));
  const int ring = *simulator.body_named("ring_0");
  simulator.attach_body(ring, "hand", {Vector3(0, 0, 1.08)});
  for (int k = 1; k <= 30; ++k) {
    simulator.move_grip("hand", {Vector3(0.01 * k, 0.02 * k, 1.08 - 0.01 * k)});
    simulator.step();
    const Vector3 expected(0.01 * k, 0, 1.08);
    ASSERT_LT((simulator.body_motion(ring).pose.position - expected).norm(), 1e-12);
  }
  simulator.detach_body(ring);
  simulator.step();
  EXPECT_NEAR(simulator.body_motion(ring).pose.position.x(), 0.31, 0.01);
}

TEST(AttachedBodies, FeelTheWholeLoadOfTheCloth) {
  // A ring at the end of its rod carries the strip that hangs on it and lies on its shelf.
  Scene scene = hanging(1, false);
  scene.colliders[0].pose.position.z() = 1.46;
  scene.colliders[0].body->joint = Joint{};
  scene.colliders[0].body->joint->lower = 0;
  for (auto& [column, r] : scene.cloth.attached[0].points) r = 8;
  Simulator simulator(scene);
  simulator.measure_wrenches(true);
  run(simulator, 5);
  const double weight = simulator.cloth().mass.sum() * g;
  EXPECT_NEAR(simulator.body_wrench(0).force.z(), -weight, 0.02 * weight);
  EXPECT_THROW(simulator.body_wrench(-1), std::out_of_range);
}

TEST(HeldBodies, CarryTheClothThatIsAttachedToThem) {
  Scene scene = hanging(0.2, false);
  Simulator simulator(scene);
  simulator.attach_body(0, "hand", {});
  for (int k = 1; k <= 90; ++k) {
    simulator.move_grip("hand", {Vector3(0, 0, 0.005 * k)});
    simulator.step();
  }
  EXPECT_NEAR(simulator.body_motion(0).pose.position.z(), 0.94 + 0.45, 1e-12);
  EXPECT_NEAR(simulator.state().positions(0, 2), 1.45, 1e-9);
  const auto saved = simulator.save();
  simulator.step();
  const Points expected = simulator.state().positions;
  simulator.restore(*saved);
  simulator.step();
  EXPECT_EQ(simulator.state().positions, expected);
}

TEST(HeldBodies, RingsFollowTheOneThatAHandDraws) {
  Simulator simulator(shipped_scene("rings"));
  simulator.attach_body(*simulator.body_named("ring_0"), "hand", {Vector3(0, 0, 1.08)});
  for (int k = 1; k <= 360; ++k) {
    simulator.move_grip("hand", {Vector3(0.6 * std::min(1.0, k / 180.0), 0, 1.08)});
    simulator.step();
  }
  double last = 0.6 - 0.0139;
  for (int ring = 0; ring < 6; ++ring) {
    const BodyMotion motion =
        simulator.body_motion(*simulator.body_named("ring_" + std::to_string(ring)));
    EXPECT_GE(motion.pose.position.x(), last) << ring;  // none has passed another
    EXPECT_LT(std::abs(motion.pose.position.y()) + std::abs(motion.pose.position.z() - 1.08),
              1e-12);
    last = motion.pose.position.x() + 0.0139;
  }
  EXPECT_LT(simulator.state().positions.col(2).maxCoeff(), 1.13);
}

}  // namespace
}  // namespace clothsim::attached_bodies_test
