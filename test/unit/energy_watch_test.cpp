#include "clothsim/simulation/energy_watch.h"

#include <cmath>
#include <limits>

#include "clothsim/dynamics/energy.h"
#include "verification/testing.h"

namespace clothsim::energy_watch_test {
namespace {

using namespace test;

const Vector3 gravity(0, 0, -9.8);
constexpr double dt = 1.0 / 90;

State resting(const Cloth& cloth) {
  return {cloth.rest_positions, Points::Zero(cloth.num_points(), 3), 0};
}

bool plausible(const Cloth& cloth, const State& before, const State& after,
               const std::vector<MovingCollider>& colliders = {}) {
  return EnergyWatch().accepts(cloth, gravity, dt, before, after, colliders);
}

TEST(EnergyWatch, FallingIsPlausible) {
  const Cloth cloth = make_grid(square_spec(10));
  State before = resting(cloth);
  State after = before;
  for (int frame = 0; frame < 20; ++frame) {
    after.velocities.col(2).array() -= 9.8 * dt;
    after.positions += dt * after.velocities;
    EXPECT_TRUE(plausible(cloth, before, after)) << frame;
    before = after;
  }
}

TEST(EnergyWatch, MotionFromNowhereIsNot) {
  const Cloth cloth = make_grid(square_spec(10));
  const State before = resting(cloth);
  State after = before;
  after.velocities = random_points(100, 3, 1);
  EXPECT_FALSE(plausible(cloth, before, after));
  after.velocities *= 1e-3;
  EXPECT_TRUE(plausible(cloth, before, after)) << "small";
}

TEST(EnergyWatch, ElasticEnergyMayTurnIntoMotion) {
  const Cloth cloth = make_grid(square_spec(10));
  State before = resting(cloth);
  before.positions *= 1.2;
  State after = resting(cloth);
  after.velocities = random_points(100, 1, 1);
  EXPECT_TRUE(plausible(cloth, before, after));
}

TEST(EnergyWatch, PinsAndCollidersPutWorkIn) {
  ClothSpec spec = square_spec(10);
  spec.pinned = {{0, 0, ""}};
  const Cloth cloth = make_grid(spec);
  const State before = resting(cloth);
  State after = before;
  after.velocities.setConstant(4);
  after.velocities.row(0).setZero();
  EXPECT_FALSE(plausible(cloth, before, after));

  State pulled = after;
  pulled.velocities.row(0).setConstant(4);
  EXPECT_TRUE(plausible(cloth, before, pulled));

  MovingCollider ball(ColliderSpec{"ball", Sphere{0.2}, Pose{}, 0.3, ""});
  EXPECT_FALSE(plausible(cloth, before, after, {ball}));
  ball.set_target({Vector3(0.1, 0, 0), Eigen::Quaterniond::Identity()}, dt);
  EXPECT_TRUE(plausible(cloth, before, after, {ball}));
}

TEST(EnergyWatch, CollidersPutWorkIntoSprings) {
  // A box that moves along x presses the first column of a cloth, whose springs take 200 times as
  // much energy as its mass.
  ClothSpec sheet = square_spec(10, 1e5);
  sheet.material.density = 0.1;
  const Cloth cloth = make_grid(sheet);
  const State before = resting(cloth);
  State after = before;
  for (int i = 0; i < 100; i += 10) {
    after.positions(i, 0) += dt;
    after.velocities(i, 0) = 1;
  }
  const auto pressed_by = [&](double x, double speed) {
    ColliderSpec spec;
    spec.shape = Cuboid{{0.1, 2, 0.1}};
    spec.pose.position = {x, 0.5, 1};
    MovingCollider box(spec);
    Pose target = spec.pose;
    target.position.x() += speed * dt;
    box.set_target(target, dt);
    box.advance(dt);
    return plausible(cloth, before, after, {box});
  };
  EXPECT_TRUE(pressed_by(-0.05, 1));
  EXPECT_FALSE(pressed_by(-0.05, 0)) << "rests";
  EXPECT_FALSE(pressed_by(-5, 1)) << "far away";
}

TEST(EnergyWatch, GrowthByLittleIsSeenInTheEnd) {
  const Cloth cloth = make_grid(square_spec(10));
  const State start{cloth.rest_positions, random_points(100, 0.1, 1), 0};
  EnergyWatch steady;
  EnergyWatch growing;
  State before = start;
  double grown = 1;  // speeds
  bool refused = false;
  for (int frame = 0; frame < 1000 && !refused; ++frame) {
    EXPECT_TRUE(steady.accepts(cloth, Vector3::Zero(), dt, start, start, {}));
    State after = before;
    after.velocities *= 1.01;
    refused = !growing.accepts(cloth, Vector3::Zero(), dt, before, after, {});
    if (!refused) grown *= 1.01;
    before = after;
  }
  EXPECT_TRUE(refused);
  EXPECT_LT(grown, 10.2);  // a hundred times the energy

  growing.restart();
  EXPECT_TRUE(growing.accepts(cloth, Vector3::Zero(), dt, before, before, {}));
}

TEST(EnergyWatch, WhatWasStoredInSpringsMayTurnIntoMotionLater) {
  // A cloth whose springs take far more energy than its mass is stretched to twice its width, by
  // the pins of one border or as it is pushed out of a shape, and then released.
  ClothSpec spec = square_spec(10, 1e5);
  spec.material.density = 0.1;
  for (int row = 0; row < 10; ++row) spec.pinned.push_back({9, row, ""});
  const Cloth cloth = make_grid(spec);
  const auto accepts_in_the_end = [&](bool by_pins, double push_out_speed) {
    EnergyWatch watch;
    State before = resting(cloth);
    constexpr int frames = 100;
    for (int frame = 1; frame <= frames; ++frame) {
      State after = before;
      after.positions.col(0) = (1 + 1.0 / frames * frame) * cloth.rest_positions.col(0);
      if (by_pins) {
        for (int i = 9; i < 100; i += 10) after.velocities(i, 0) = 1 / (frames * dt);
      }
      EXPECT_TRUE(watch.accepts(cloth, Vector3::Zero(), dt, before, after, {}, push_out_speed))
          << frame;
      before = after;
    }
    State after = resting(cloth);
    const double energy = elastic_energy(cloth, before.positions) / 2;
    const double mass = (cloth.inv_mass.array() > 0).select(cloth.mass.array(), 0).sum();
    after.velocities.col(2) = (cloth.inv_mass.array() > 0)
                                  .select(Scalars::Constant(100, std::sqrt(2 * energy / mass)), 0);
    return watch.accepts(cloth, Vector3::Zero(), dt, before, after, {});
  };
  EXPECT_TRUE(accepts_in_the_end(true, 0));
  EXPECT_TRUE(accepts_in_the_end(false, 2));
  EXPECT_FALSE(accepts_in_the_end(false, 0)) << "by nothing";
}

TEST(EnergyWatch, RoundingsOfAClothWithoutWeightArePlausible) {
  const Cloth cloth = make_grid(square_spec(10));
  const State start{cloth.rest_positions, Points::Zero(100, 3), 0};
  State after = start;
  after.velocities = random_points(100, 1e-13, 1);
  EXPECT_TRUE(EnergyWatch().accepts(cloth, Vector3::Zero(), dt, start, after, {}));
  after.velocities *= 1e11;
  EXPECT_FALSE(EnergyWatch().accepts(cloth, Vector3::Zero(), dt, start, after, {}));
}

TEST(EnergyWatch, WhatPushesOutDoesNotFlingAbout) {
  const Cloth cloth = make_grid(square_spec(10));
  const State start{cloth.rest_positions, Points::Zero(100, 3), 0};
  State after = start;
  const auto accepts = [&](double speed, double push_out_speed) {
    after.velocities.setConstant(speed / std::sqrt(3));
    return EnergyWatch().accepts(cloth, Vector3::Zero(), dt, start, after, {}, push_out_speed);
  };
  EXPECT_FALSE(accepts(10, 0));
  EXPECT_TRUE(accepts(10, 2));
  EXPECT_FALSE(accepts(100, 2));
}

TEST(EnergyWatch, WhatIsNotFiniteIsNotPlausible) {
  const Cloth cloth = make_grid(square_spec(10));
  const State before = resting(cloth);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), 1e200}) {
    State after = before;
    after.velocities(3, 1) = bad;
    EXPECT_FALSE(plausible(cloth, before, after)) << bad;
  }
}

}  // namespace
}  // namespace clothsim::energy_watch_test
