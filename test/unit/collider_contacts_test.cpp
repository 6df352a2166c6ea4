#include "clothsim/constraints/collider_contacts.h"

#include <cmath>

#include "algebra.h"
#include "verification/testing.h"

namespace clothsim::collider_contacts_test {
namespace {

using namespace test;

constexpr double displacement_factor = 0.5;
constexpr double h = 1e-3;

std::vector<MovingCollider> one(const Shape& shape, double friction = 0) {
  ColliderSpec spec;
  spec.name = "it";
  spec.shape = shape;
  spec.friction = friction;
  return {MovingCollider(spec)};
}

/// `count` free masses of 1 kg without springs.
Cloth loose(int count) { return make_grid(chain_spec(count, 1, 0)); }

/// Free flight over h, then contact.
void step(ColliderContacts& contacts, std::vector<MovingCollider>& colliders, const Cloth& cloth,
          State& state, double dt = h) {
  for (MovingCollider& collider : colliders) collider.advance(dt);
  const Points start = state.positions;
  state.positions += dt * state.velocities;
  const Points before = state.velocities;
  contacts.prepare(colliders, cloth, {dt, displacement_factor, start, before, Workers()}, state);
  for (int i = 0; i < 50; ++i) {
    contacts.solve_pass(cloth, state.positions, nullptr, state.velocities);
  }
  state.positions += displacement_factor * dt * (state.velocities - before);
  contacts.project_positions(colliders, cloth, start, state);
}

TEST(ColliderContacts, APointComesToRestOnAPlane) {
  // Restitution zero, no point below the offset, no velocity left behind.
  auto colliders = one(Plane{});
  const Cloth cloth = loose(2);
  State state{Points::Zero(2, 3), Points::Zero(2, 3), 0};
  state.positions.col(2).setConstant(0.1);
  state.positions(1, 0) = 5;
  ColliderContacts contacts;
  for (int k = 0; k < 500; ++k) {
    state.velocities.col(2).array() -= 9.8 * h;
    step(contacts, colliders, cloth, state);
    EXPECT_GE(state.positions.col(2).minCoeff(), surface_offset - 1e-15);
  }
  EXPECT_EQ(contacts.count(), 2);
  EXPECT_NEAR(state.positions(0, 2), surface_offset, 1e-9);
  EXPECT_LT(max_speed(state), 1e-9);
}

TEST(ColliderContacts, NothingTunnelsThroughAPlane) {
  for (const double speed : {1.0, 10.0, 100.0, 1e4}) {
    auto colliders = one(Plane{});
    const Cloth cloth = loose(3);
    State state{Points::Zero(3, 3), Points::Zero(3, 3), 0};
    state.positions.col(2) << 0.01, 0.02, 0.5;
    state.velocities.rowwise() = Eigen::RowVector3d(0.3 * speed, 0, -speed);
    ColliderContacts contacts;
    for (int k = 0; k < 100; ++k) {
      step(contacts, colliders, cloth, state, 0.01);
      ASSERT_GE(state.positions.col(2).minCoeff(), surface_offset - 1e-12) << speed;
    }
    EXPECT_NEAR(state.positions(0, 2), surface_offset, 1e-9) << speed;
    EXPECT_NEAR(state.velocities(0, 2), 0, 1e-9) << "restitution at " << speed;
    EXPECT_NEAR(state.velocities(0, 0), 0.3 * speed, 1e-9 * speed) << "no friction";
  }
}

TEST(ColliderContacts, ATwoSidedPlaneHoldsEachSide) {
  for (const double speed : {1.0, 10.0, 100.0}) {
    auto colliders = one(Plane{true});
    const Cloth cloth = loose(2);
    State state{Points::Zero(2, 3), Points::Zero(2, 3), 0};
    state.positions.col(2) << 0.02, -0.02;
    state.velocities.col(2) << -speed, speed;
    ColliderContacts contacts;
    for (int k = 0; k < 50; ++k) {
      step(contacts, colliders, cloth, state, 0.005);
      ASSERT_GE(state.positions(0, 2), surface_offset - 1e-12) << speed;
      ASSERT_LE(state.positions(1, 2), -surface_offset + 1e-12) << speed;
    }
  }
}

TEST(ColliderContacts, NothingTunnelsThroughASphere) {
  // A point that flies at the ball, at offset b from its axis: for b < R it must stop on the near
  // side for any length of its step; for b > R it must not touch the ball.
  const double radius = 0.2;
  for (const double speed : {1.0, 10.0, 100.0}) {
    for (const double b : {0.0, 0.05, 0.15, 0.19, 0.21}) {
      auto colliders = one(Sphere{radius});
      const Cloth cloth = loose(2);
      State state{Points::Zero(2, 3), Points::Zero(2, 3), 0};
      state.positions.row(0) << b, 0, 0.5;
      state.positions.row(1) << 9, 9, 9;
      state.velocities(0, 2) = -speed;
      ColliderContacts contacts;
      const double dt = 1.0 / 90;
      for (int k = 0; k * dt * speed < 3; ++k) {
        step(contacts, colliders, cloth, state, dt);
        const Vector3 x = state.positions.row(0).transpose();
        ASSERT_GE(x.norm(), radius + surface_offset - 1e-12) << speed << " m/s, b " << b;
        if (b < radius && x.z() < 0) {
          ASSERT_GE(x.head<2>().norm(), radius) << "through it at " << speed << " m/s, b " << b;
        }
      }
      if (b > radius) {
        EXPECT_EQ(state.velocities.row(0), Eigen::RowVector3d(0, 0, -speed));
      } else {
        EXPECT_GT(state.velocities(0, 2), -speed);
      }
      EXPECT_EQ(state.positions.row(1), Eigen::RowVector3d(9, 9, 9));
    }
  }
}

TEST(ColliderContacts, ADrivenSphereTakesPointsAlong) {
  // Head on, at v h up to five radii a step: the point ends in front, with the sphere's speed.
  for (const double speed : {1.0, 10.0, 100.0}) {
    auto colliders = one(Sphere{0.2});
    const Cloth cloth = loose(2);
    State state{Points::Zero(2, 3), Points::Zero(2, 3), 0};
    state.positions.row(0) << 0, 0, 0.3;
    state.positions.row(1) << 9, 9, 9;
    ColliderContacts contacts;
    const double dt = 0.01;
    const int steps = static_cast<int>(1 + 1 / (speed * dt));
    for (int k = 1; k <= steps; ++k) {
      colliders[0].set_target({Vector3(0, 0, speed * dt * k), Eigen::Quaterniond::Identity()}, dt);
      step(contacts, colliders, cloth, state, dt);
      const double ahead = state.positions(0, 2) - colliders[0].pose().position.z();
      ASSERT_GE(ahead, 0.2 + surface_offset - 1e-12) << speed << " m/s, step " << k;
    }
    EXPECT_NEAR(state.velocities(0, 2), speed, 1e-9 * speed);
  }
}

TEST(ColliderContacts, ABarThatTurnsFarInOneStepTakesAPointAlong) {
  // Along x it turns by 2.5 rad about z; the point is met at 1.2 rad.
  auto colliders = one(Capsule{1, 0.02});
  const Eigen::Quaterniond along_x = turn_between(Vector3::UnitZ(), Vector3::UnitX());
  colliders[0].place({Vector3::Zero(), along_x});
  colliders[0].set_target({Vector3::Zero(), Eigen::AngleAxisd(2.5, Vector3::UnitZ()) * along_x},
                          0.01);
  const Cloth cloth = loose(2);
  State state{Points::Zero(2, 3), Points::Zero(2, 3), 0};
  state.positions.row(0) << 0.4 * std::cos(1.2), 0.4 * std::sin(1.2), 0;
  state.positions.row(1) << 9, 9, 9;
  ColliderContacts contacts;
  step(contacts, colliders, cloth, state, 0.01);
  const double angle = std::atan2(state.positions(0, 1), state.positions(0, 0));
  EXPECT_NEAR(angle, 2.5 + std::asin(0.02 / 0.4), 0.01) << "in front of the bar";
}

TEST(ColliderContacts, AnImpulseOnAnEdgeMovesItsEndsByTheirMasses) {
  // A sheet without springs falls on a bar at the share x of its width: one impulse P ends the
  // approach there, of which its sides take (1 - x) P / m_0 and x P / m_1.
  const double x = 0.3, m_0 = 1, m_1 = 0.25, radius = 0.01, speed = 1;
  ClothSpec spec;
  spec.columns = spec.rows = 2;
  spec.material.springs = {false, false, false};
  Cloth cloth = make_grid(spec);
  cloth.mass << m_0, m_1, m_0, m_1;
  cloth.inv_mass = cloth.mass.cwiseInverse();
  ColliderSpec bar;
  bar.name = "bar";
  bar.shape = Capsule{4, radius};
  bar.friction = 0;
  bar.pose.position = {x, 0.5, 0};
  bar.pose.orientation = turn_between(Vector3::UnitZ(), Vector3::UnitY());
  std::vector<MovingCollider> colliders{MovingCollider(bar)};
  State state{cloth.rest_positions, Points::Zero(4, 3), 0};
  state.positions.col(2).setConstant(radius + surface_offset);
  state.velocities.col(2).setConstant(-speed);
  ColliderContacts contacts;
  step(contacts, colliders, cloth, state);
  const double impulse = speed / ((1 - x) * (1 - x) / m_0 + x * x / m_1);
  for (const int i : {0, 2}) {
    EXPECT_NEAR(state.velocities(i, 2), (1 - x) * impulse / m_0 - speed, 1e-3 * speed);
    EXPECT_NEAR(state.velocities(i + 1, 2), x * impulse / m_1 - speed, 1e-3 * speed);
  }
  EXPECT_LT(kinetic_energy(cloth, state), 2 * (m_0 + m_1) * speed * speed / 2);
}

TEST(ColliderContacts, FrictionStaysInCoulombsCone) {
  // One impact: the normal impulse is m v_n; friction takes min(mu v_n, v_t) from the sliding.
  const double mu = 0.3;
  for (const double slide : {0.1, 0.59, 0.61, 5.0}) {
    auto colliders = one(Plane{}, mu);
    const Cloth cloth = loose(2);
    State state{Points::Zero(2, 3), Points::Zero(2, 3), 0};
    state.positions.col(2).setConstant(surface_offset);
    state.velocities.rowwise() = Eigen::RowVector3d(0.6 * slide, -0.8 * slide, -2);
    ColliderContacts contacts;
    step(contacts, colliders, cloth, state);
    const double left = std::max(0.0, slide - mu * 2);
    EXPECT_NEAR(state.velocities(0, 0), 0.6 * left, 1e-9);
    EXPECT_NEAR(state.velocities(0, 1), -0.8 * left, 1e-9);
    EXPECT_NEAR(state.velocities(0, 2), 0, 1e-9);
  }
}

TEST(ColliderContacts, AFastPointSlidesOnAThinPlateAsOnAPlane) {
  // In a step the point goes much farther than the plate is thick, so it could tunnel. From speed v
  // it comes to rest after v^2 / (2 friction g).
  constexpr double speed = 10, friction = 0.8, thickness = 0.002;
  const Eigen::AngleAxisd turn(0.7, Vector3(1, 2, 3).normalized());
  const Eigen::Quaterniond tilt(turn);
  for (const double fall : {0.0, 0.5}) {  // [m/s] at the impact
    auto colliders = one(Cuboid{{20, 20, thickness}}, friction);
    colliders[0].place({Vector3::Zero(), tilt});
    const Cloth cloth = loose(2);
    State state{Points::Zero(2, 3), Points::Zero(2, 3), 0};
    const auto put = [&](Points& to, int i, const Vector3& v) {
      to.row(i) = (tilt * v).transpose();
    };
    put(state.positions, 0, {-7, 0, thickness / 2 + surface_offset});
    put(state.positions, 1, {0, 0, 9});
    put(state.velocities, 0, {speed, 0, -fall});
    ColliderContacts contacts;
    double last = -7;
    for (int k = 0; k < 1500; ++k) {
      state.velocities.row(0) -= 9.8 * h * (tilt * Vector3::UnitZ()).transpose();
      step(contacts, colliders, cloth, state);
      const Vector3 x = tilt.conjugate() * row(state.positions, 0);
      ASSERT_GE(x.z(), thickness / 2 + surface_offset - 1e-12) << k;
      ASSERT_GE(x.x(), last - 1e-9) << k << ": against its velocity";
      last = x.x();
    }
    const double landing = speed - friction * fall;  // the same impulse stops its fall
    EXPECT_NEAR(last + 7, landing * landing / (2 * friction * 9.8), 0.01) << fall;
    EXPECT_LT(row(state.velocities, 0).norm(), 1e-9);
  }
}

TEST(ColliderContacts, PinsAreNotPushed) {
  ClothSpec spec = chain_spec(2, 1, 0);
  spec.pinned = {{0, 0, ""}};
  const Cloth cloth = make_grid(spec);
  auto colliders = one(Plane{}, 0.5);
  State state{Points::Zero(2, 3), Points::Zero(2, 3), 0};
  state.positions.col(2).setConstant(-0.01);
  ColliderContacts contacts;
  for (int k = 0; k < 11; ++k) step(contacts, colliders, cloth, state);
  EXPECT_EQ(state.positions(0, 2), -0.01);
  EXPECT_GE(state.positions(1, 2), surface_offset - 1e-15);
}

TEST(ColliderContacts, PointsOutOfReachAreUntouched) {
  auto colliders = one(Sphere{0.2}, 0.5);
  const Cloth cloth = loose(50);
  State state{random_points(50, 1, 1), random_points(50, 0.1, 2), 0};
  state.positions.col(2).array() += 2;
  const State before = state;
  ColliderContacts contacts;
  step(contacts, colliders, cloth, state);
  EXPECT_EQ(contacts.count(), 0);
  EXPECT_EQ(state.positions, before.positions + h * before.velocities);
  EXPECT_EQ(state.velocities, before.velocities);
}

TEST(ColliderContacts, LeavingOutFarPointsChangesNothing) {
  // With one point so fast that all others might touch next, the twin checks every point.
  constexpr int count = 400;
  const Cloth cloth = loose(count), with_fast_one = loose(count + 1);
  const Shape shapes[] = {Sphere{0.3}, Plane{}, Capsule{0.8, 0.05}, Cuboid{{0.8, 0.3, 0.2}}};
  for (const Shape& shape : shapes) {
    auto colliders = one(shape, 0.4), others = one(shape, 0.4);
    State state{random_points(count, 0.8, 1), random_points(count, 6, 2), 0};
    State other{Points::Zero(count + 1, 3), Points::Zero(count + 1, 3), 0};
    other.positions.topRows(count) = state.positions;
    other.velocities.topRows(count) = state.velocities;
    other.positions.row(count) << 1e3, 1e3, 1e3;
    other.velocities.row(count) << 1e5, 1e5, 1e5;
    ColliderContacts contacts, all;
    int touched = 0;
    for (int k = 0; k < 60; ++k) {
      const Eigen::Quaterniond turned(Eigen::AngleAxisd(0.1 * k, Vector3(0, 0.6, 0.8)));
      for (auto* c : {&colliders, &others}) {
        c->front().set_target({Vector3(0.004 * k, 0, 0), turned}, h);
      }
      step(contacts, colliders, cloth, state);
      step(all, others, with_fast_one, other);
      const Points apart = state.positions - other.positions.topRows(count);
      const Points faster = state.velocities - other.velocities.topRows(count);
      ASSERT_LT(apart.cwiseAbs().maxCoeff(), 1e-10) << k;
      ASSERT_LT(faster.cwiseAbs().maxCoeff(), 1e-7) << k;
      touched += contacts.count();
    }
    EXPECT_GT(touched, 15);
  }
}

TEST(ColliderContacts, APointAtTheCentreOfASphereComesOut) {
  auto colliders = one(Sphere{0.2});
  const Cloth cloth = loose(2);
  State state{Points::Zero(2, 3), Points::Zero(2, 3), 0};
  state.positions.row(1) << 9, 9, 9;
  ColliderContacts contacts;
  int steps = 0;
  do {
    const Vector3 before = state.positions.row(0);
    step(contacts, colliders, cloth, state);
    const double moved = (state.positions.row(0).transpose() - before).norm();
    EXPECT_LE(moved, 2 * recovery_speed * h) << "in step " << steps;
  } while (contacts.recovers() && ++steps < 400);
  EXPECT_NEAR(steps, 0.2 / (recovery_speed * h), 2);
  EXPECT_GE(state.positions.row(0).norm(), 0.2 - 1e-12);
  EXPECT_LT(state.positions.row(0).norm(), 0.2 + 2.1e-3);
  EXPECT_LE(max_speed(state), recovery_speed + 1e-12);
}

TEST(ColliderContacts, APinThatIsLetGoInASolidComesOutNoFaster) {
  ClothSpec spec = chain_spec(2, 1, 0);
  spec.pinned = {{0, 0, ""}};
  const Cloth pinned = make_grid(spec), free = loose(2);
  for (const Shape& shape : {Shape(Sphere{0.2}), Shape(Plane{}), Shape(Cuboid{{0.4, 0.4, 0.4}})}) {
    auto colliders = one(shape);
    State state{Points::Zero(2, 3), Points::Zero(2, 3), 0};
    state.positions.row(0) << 0, 0.01, -0.1;
    state.positions.row(1) << 9, 9, 9;
    ColliderContacts contacts;
    for (int k = 0; k < 3; ++k) step(contacts, colliders, pinned, state);
    EXPECT_EQ(state.positions(0, 2), -0.1);
    int steps = 0;
    do {
      const Vector3 before = state.positions.row(0);
      step(contacts, colliders, free, state);
      const double moved = (state.positions.row(0).transpose() - before).norm();
      ASSERT_LE(moved, 2 * recovery_speed * h) << "in step " << steps;
    } while (contacts.recovers() && ++steps < 400);
    EXPECT_GT(steps, 0.09 / (recovery_speed * h));
    EXPECT_LT(steps, 400);
  }
}

TEST(ColliderContacts, ResetForgetsTheImpulses) {
  auto colliders = one(Plane{}, 0.5);
  const Cloth cloth = loose(2);
  const State start{Points::Constant(2, 3, surface_offset), Points::Constant(2, 3, -1), 0};
  ColliderContacts used;
  State state = start;
  step(used, colliders, cloth, state);
  EXPECT_GT(used.count(), 0);
  used.reset();
  EXPECT_EQ(used.count(), 0);
  State again = start;
  step(used, colliders, cloth, again);
  State first = start;
  ColliderContacts fresh;
  step(fresh, colliders, cloth, first);
  EXPECT_EQ(again.velocities, first.velocities);
  EXPECT_EQ(again.positions, first.positions);
}

}  // namespace
}  // namespace clothsim::collider_contacts_test
