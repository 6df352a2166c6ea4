#include <array>
#include <vector>

#include "clothsim/constraints/self_contacts.h"
#include "clothsim/geometry/intersections.h"
#include "surface_testing.h"

namespace clothsim::surface_contacts_test {
namespace {

using namespace test;

constexpr double displacement_factor = 0.5;
const Workers alone;
constexpr double h = 1e-3;
constexpr double thickness = strip_thickness;

/// Contact solves a step of `dt` [s] from `start` to convergence, and nothing crosses. Returns the
/// number of points that the guard held back.
int answer(SelfContacts& contacts, const Cloth& cloth, const Points& start, double dt, State& state,
           double left = 0) {
  const Points before = state.velocities;
  const ContactStep contact_step{dt, displacement_factor, start, before, alone, left};
  contacts.prepare(cloth, contact_step, state);
  for (int i = 0; i < 2000 && contacts.solve_pass(0, state.velocities) > 1e-14; ++i) {
  }
  state.positions += displacement_factor * dt * (state.velocities - before);
  return contacts.guard(cloth, contact_step, Points(state.positions), state);
}

/// One step: points move, and contact corrects their velocities.
void step(SelfContacts& contacts, const Cloth& cloth, State& state) {
  const Points start = state.positions;
  state.positions += h * state.velocities;
  answer(contacts, cloth, start, h, state);
}

Eigen::RowVector3d momentum(const Cloth& cloth, const State& state) {
  return (state.velocities.array().colwise() * cloth.mass.array()).colwise().sum();
}

Eigen::RowVector3d angular_momentum(const Cloth& cloth, const State& state) {
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  for (int i = 0; i < cloth.num_points(); ++i) {
    sum += cloth.mass[i] * state.positions.row(i).cross(state.velocities.row(i));
  }
  return sum;
}

TEST(SurfaceContacts, LayersStopWhereTheyTouchAndKeepTheirMomentum) {
  // Points land inside triangles: contact of points with points alone would let them pass.
  const Cloth cloth = strip(8);
  State state = folded(cloth, 0.05, Eigen::RowVector3d(0.031, 0.007, 0));
  for (const int i : {6, 7, 14, 15}) state.velocities(i, 2) = -1;
  const Eigen::RowVector3d before = momentum(cloth, state);
  SelfContacts contacts(cloth, SelfCollision::surface);
  for (int i = 0; i < 60; ++i) step(contacts, cloth, state);
  EXPECT_LT((momentum(cloth, state) - before).norm(), 1e-12);
  EXPECT_NEAR(min_distance(cloth, state.positions), 2 * thickness, 2e-4);
  EXPECT_EQ(count_intersections(cloth, state.positions), 0);
}

/// A strip whose last cell lies on its first one, which is held as if it lay on a table.
State lying_double(Cloth& cloth) {
  State state = folded(cloth, 2.1 * thickness, Eigen::RowVector3d(0, 0.007, 0));
  const double way_round[4][2] = {{0.4, 0}, {0.5, 0}, {0.6, 0.1}, {0.5, 0.25}};
  for (int row = 0; row < 2; ++row) {
    for (int k = 0; k < 4; ++k) {
      state.positions.row(row * 8 + 2 + k) << way_round[k][0], 0.1 * row, way_round[k][1];
    }
  }
  for (const int i : {0, 1, 8, 9}) cloth.inv_mass[i] = 0;
  return state;
}

TEST(SurfaceContacts, FourPointsOfALightClothCarryTheHundredNewtonsOfAFinger) {
  // In the steps that its springs need. The cloth weighs 0.14 N, which does not matter here.
  constexpr double dt = 1e-4;
  constexpr double force = 100.0 / 4;  // on each [N]
  Cloth cloth = strip(8, 0.3);
  cloth.mass *= 0.2 / 100;  // of 0.2 kg/m^2
  cloth.inv_mass /= 0.2 / 100;
  State state = lying_double(cloth);
  SelfContacts contacts(cloth, SelfCollision::surface);
  for (int i = 0; i < 1000; ++i) {
    const Points start = state.positions;
    state.positions += dt / 2 * state.velocities;
    for (const int pressed : {6, 7, 14, 15}) {
      state.velocities(pressed, 2) -= dt * force * cloth.inv_mass[pressed];
    }
    state.positions += dt / 2 * state.velocities;
    ASSERT_EQ(answer(contacts, cloth, start, dt, state), 0) << "the guard has to hold it, " << i;
    ASSERT_GT(min_distance(cloth, state.positions), 0.999 * 2 * thickness) << i;
  }
  EXPECT_LT(min_distance(cloth, state.positions), 1.001 * 2 * thickness) << "it is not pressed";
  EXPECT_LT(max_speed(state), 1e-6);
  EXPECT_EQ(count_intersections(cloth, state.positions), 0);
}

TEST(SurfaceContacts, EdgesThatCrossInMidAirStop) {
  // Two edges at a right angle, no point near a triangle.
  const Cloth cloth = strip(8);
  State state = folded(cloth, 0.05, Eigen::RowVector3d(0.03, 0, 0));
  state.positions.row(7) << 0.05, -0.2, 0.05;
  state.positions.row(15) << 0.05, 0.3, 0.05;
  state.positions.row(6) << 0.3, -0.2, 0.3;
  state.positions.row(14) << 0.3, 0.3, 0.3;
  for (const int i : {7, 15}) state.velocities(i, 2) = -1;
  const Eigen::RowVector3d before = angular_momentum(cloth, state);
  SelfContacts contacts(cloth, SelfCollision::surface);
  for (int i = 0; i < 60; ++i) {
    step(contacts, cloth, state);
    EXPECT_GE(min_distance(cloth, state.positions), 2 * thickness - 2e-4);
  }
  EXPECT_NEAR(min_distance(cloth, state.positions), 2 * thickness, 2e-4);
  EXPECT_LT((angular_momentum(cloth, state) - before).norm(), 2e-5) << "of " << before.norm();
  EXPECT_EQ(count_intersections(cloth, state.positions), 0);
}

TEST(SurfaceContacts, AStepOfImpulsesKeepsBothMomenta) {
  // Impulses act in the middle of the step, so the angular momentum is taken there.
  const Cloth cloth = strip(8, 0.4);
  State state = folded(cloth, 2.05 * thickness, Eigen::RowVector3d(0.031, 0.007, 0));
  state.velocities = random_points(cloth.num_points(), 0.3, 3);
  for (const int i : {6, 7, 14, 15}) state.velocities(i, 2) -= 1;
  const Points start = state.positions;
  state.positions += h * state.velocities;
  State middle = state;
  middle.positions -= displacement_factor * h * state.velocities;
  const Eigen::RowVector3d linear = momentum(cloth, middle);
  const Eigen::RowVector3d angular = angular_momentum(cloth, middle);
  const double energy = middle.velocities.squaredNorm();
  SelfContacts contacts(cloth, SelfCollision::surface);
  contacts.prepare(cloth, {h, displacement_factor, start, Points(state.velocities), alone}, state);
  for (int i = 0; i < 500; ++i) contacts.solve_pass(0, state.velocities);
  ASSERT_GT(contacts.count(), 2);
  middle.velocities = state.velocities;
  EXPECT_LT((momentum(cloth, middle) - linear).norm(), 1e-13);
  // Friction at a distance, 2 * thickness apart, has a moment; that of points has it too.
  EXPECT_LT((angular_momentum(cloth, middle) - angular).norm(), 0.05 * angular.norm());
  EXPECT_LT(middle.velocities.squaredNorm(), energy);
}

TEST(SurfaceContacts, FrictionTurnsByItsImpulseTimesTheDistanceOfTheLayersAndNoMore) {
  // Layers touch where they are 2 * thickness apart, and +-J act there: a moment d x J, which would
  // be the spin of a cloth through its thickness; points have none. Nothing else turns it.
  const Cloth cloth = strip(8, 0.4);
  State state = folded(cloth, 0.4, Eigen::RowVector3d(0, 0, 0));
  state.positions.row(7) << 0.075, 0.05, 2.02 * thickness;  // a corner alone comes down
  state.velocities.row(7) << 0.5, 0.2, -1;
  const Points start = state.positions;
  state.positions += h * state.velocities;
  State middle = state;
  middle.positions -= displacement_factor * h * state.velocities;
  const Eigen::RowVector3d before = angular_momentum(cloth, middle);
  SelfContacts contacts(cloth, SelfCollision::surface);
  contacts.prepare(cloth, {h, displacement_factor, start, Points(state.velocities), alone}, state);
  for (int i = 0; i < 100; ++i) contacts.solve_pass(0, state.velocities);
  ASSERT_EQ(contacts.count(), 1);
  const Eigen::RowVector3d impulse =
      cloth.mass[7] * (state.velocities.row(7) - middle.velocities.row(7));
  EXPECT_NEAR(impulse.head<2>().norm(), 0.4 * impulse.z(), 1e-12) << "it slides";
  middle.velocities = state.velocities;
  const Eigen::RowVector3d apart(0, 0, middle.positions(7, 2));  // from the sheet at z = 0
  EXPECT_NEAR(apart.z(), 2 * thickness, 1e-3);
  const Eigen::RowVector3d change = angular_momentum(cloth, middle) - before;
  EXPECT_GT(change.norm(), 1e-3);
  EXPECT_LT((change - apart.cross(impulse)).norm(), 1e-13);
}

TEST(SurfaceContacts, FrictionStopsALayerAsLongAsCoulombSays) {
  // Pressed down with acceleration g, it slows down by mu g.
  const double mu = 0.4, g = 10;
  const Cloth cloth = [&] {
    Cloth c = strip(8, mu);
    for (int i = 0; i < 16; ++i) {
      if (i != 6 && i != 7 && i != 14 && i != 15) c.inv_mass[i] = 0;
    }
    return c;
  }();
  State state = folded(cloth, 2 * thickness, Eigen::RowVector3d(0.031, 0.007, 0));
  for (const int i : {2, 10}) state.positions(i, 2) = 0;  // only the layers touch
  for (const int i : {5, 13}) state.positions(i, 2) = 1;
  for (const int i : {6, 7, 14, 15}) state.velocities(i, 1) = 0.1;
  SelfContacts contacts(cloth, SelfCollision::surface);
  for (int k = 0; k < 10; ++k) {
    const Points start = state.positions;
    state.positions += displacement_factor * h * state.velocities;
    for (const int i : {6, 7, 14, 15}) state.velocities(i, 2) -= g * h;
    state.positions += displacement_factor * h * state.velocities;
    const Points before = state.velocities;
    contacts.prepare(cloth, {h, displacement_factor, start, before, alone}, state);
    for (int i = 0; i < 2000 && contacts.solve_pass(0, state.velocities) > 1e-14; ++i) {
    }
    state.positions += displacement_factor * h * (state.velocities - before);
  }
  double mean = 0;
  for (const int i : {6, 7, 14, 15}) mean += state.velocities(i, 1) / 4;
  EXPECT_NEAR(mean, 0.1 - mu * g * 10 * h, 0.01 * mu * g * 10 * h);
}

TEST(SurfaceContacts, WhatPassesLeaveOutIsWithinThePrecision) {
  // A crumpled cloth that falls in on itself.
  const Cloth cloth = cloth_of(12, 12, thickness);
  Points start = 0.3 * cloth.rest_positions + random_points(cloth.num_points(), 0.02, 3);
  State state{start, Points::Zero(cloth.num_points(), 3), 0};
  state.velocities = -10 * (start.rowwise() - start.colwise().mean());
  state.positions += h * state.velocities;
  const Points before = state.velocities;
  SelfContacts contacts(cloth, SelfCollision::surface);
  contacts.prepare(cloth, {h, displacement_factor, start, before, alone}, state);

  constexpr double precision = 1e-6, none_left_out = -1;
  int passes = 0;
  while (contacts.solve_pass(precision, state.velocities) > precision) ++passes;
  EXPECT_GT(contacts.count(), 50);
  EXPECT_GT(passes, 10);
  // One more pass changes as much as the last one, plus the changes left out: an eightieth of
  // the precision at each of four points, of which one may be due and one have come since.
  EXPECT_LT(contacts.solve_pass(none_left_out, state.velocities), (1 + 4 * 2 / 80.0) * precision);
}

constexpr int steps_of_a_frame = 10;

TEST(SurfaceContacts, TheWayOfSeveralStepsIsJudgedAtTheFramesEnd) {
  // A layer is moved through another, 20 um below, by 5 um a step.
  const Cloth cloth = strip(8);
  State state = folded(cloth, 2e-5, Eigen::RowVector3d(0.031, 0.007, 0));
  SelfContacts contacts(cloth, SelfCollision::surface);
  const Points none = Points::Zero(cloth.num_points(), 3);
  for (int left = steps_of_a_frame; left > 0; --left) {
    const Points start = state.positions;
    const ContactStep contact_step{h, displacement_factor, start, none, alone, left * h};
    contacts.prepare(cloth, contact_step, state);
    state.velocities.setZero();
    for (const int i : {6, 7, 14, 15}) state.positions(i, 2) -= 5e-6;
    const int held_back = contacts.guard(cloth, contact_step, Points(state.positions), state);
    EXPECT_EQ(held_back > 0, left == 1) << left;
  }
  EXPECT_EQ(count_intersections(cloth, state.positions), 0);
}

TEST(SurfaceContacts, WhatTouchesUntilTheFramesEndIsSeenAhead) {
  // By 0.2 mm in a frame, of which the layers may approach by half: as with a search in each step.
  const Cloth cloth = strip(8);
  const auto after_a_frame = [&](bool looks_once) {
    State state = folded(cloth, 2 * thickness + 1e-4, Eigen::RowVector3d(0.031, 0.007, 0));
    for (const int i : {6, 7, 14, 15}) state.velocities(i, 2) = -2e-4 / (steps_of_a_frame * h);
    SelfContacts contacts(cloth, SelfCollision::surface);
    for (int left = steps_of_a_frame; left > 0; --left) {
      const Points start = state.positions;
      state.positions += h * state.velocities;
      answer(contacts, cloth, start, h, state, looks_once ? left * h : 0);
    }
    EXPECT_GT(contacts.count(), 0);
    return state.positions;
  };
  EXPECT_LT((after_a_frame(true) - after_a_frame(false)).cwiseAbs().maxCoeff(), 1e-7);
}

TEST(SurfaceContacts, NoPushGrowsBeyondTheWeightOfTheClothWhereNothingCanYield) {
  const Cloth cloth = strip(8);
  State state = folded(cloth, 2 * thickness, Eigen::RowVector3d(0.031, 0.007, 0));
  SelfContacts contacts(cloth, SelfCollision::surface);
  const ContactStep contact_step{h, displacement_factor, state.positions, state.velocities, alone};
  constexpr double speed = 0.1;
  const auto press = [&] {
    state.velocities.setZero();
    for (const int i : {6, 7, 14, 15}) state.velocities(i, 2) = -speed;
  };
  press();
  contacts.prepare(cloth, contact_step, state);
  for (int pass = 0; pass < 1000; ++pass) {
    press();
    contacts.solve_pass(0, state.velocities);
  }
  Points impulses = Points::Zero(cloth.num_points(), 3);
  contacts.add_impulses(impulses);
  const double up = impulses.col(2).cwiseMax(0).sum();
  const double mass = cloth.mass.sum();
  EXPECT_GT(up, 9.81 * mass * h);
  EXPECT_LT(up, contacts.count() * (9.81 * mass * h + 2 * mass * speed));
}

/// Two layers that were pressed together at 0.1 m/s in the last step.
struct Pressed {
  Cloth cloth = strip(8);
  State state = folded(cloth, 2 * thickness, Eigen::RowVector3d(0.031, 0.007, 0));
  SelfContacts contacts{cloth, SelfCollision::surface};
  ContactStep contact_step{h, displacement_factor, state.positions, state.velocities, alone};

  Pressed() {
    for (const int i : layer) state.velocities(i, 2) = -0.1;
    contacts.prepare(cloth, contact_step, state);
    for (int pass = 0; pass < 100; ++pass) contacts.solve_pass(0, state.velocities);
    state.velocities.setZero();
  }

  /// Plates without room between them hold these points.
  Pinches held(const std::vector<int>& points) const {
    const MovingCollider plate{ColliderSpec{}};
    Pinches pinches;
    pinches.start_over(h);
    for (const int i : points) {
      const Vector3 x = row(state.positions, i), up(0, 0, 1);
      pinches.add(i, x, {&plate, up, 0, thickness, 0, true}, {&plate, -up, 0, thickness, 0, true},
                  cloth);
    }
    return pinches;
  }

  static constexpr std::array<int, 4> layer = {6, 7, 14, 15};
};

TEST(SurfaceContacts, WhatCollidersHoldGetsNothingOfTheLastImpulses) {
  Pressed p;
  std::vector<int> all;
  for (int i = 0; i < p.cloth.num_points(); ++i) all.push_back(i);
  p.contacts.prepare(p.cloth, p.contact_step, p.state);
  EXPECT_GT(p.state.velocities.norm(), 0.05);
  p.contacts.release_pinched(p.held(all), p.state.velocities);
  EXPECT_LT(p.state.velocities.norm(), 1e-15);
  EXPECT_EQ(p.contacts.count(), 0);
}

TEST(SurfaceContacts, NextToWhatCollidersHoldALastImpulseIsNoStrongerThanOneMayBe) {
  Pressed p;
  p.cloth.mass *= 1e-3;  // so that its weight is small beside that impulse
  p.contacts.prepare(p.cloth, p.contact_step, p.state);
  const double given = p.state.velocities.norm();
  p.contacts.release_pinched(p.held({Pressed::layer.begin(), Pressed::layer.end()}),
                             p.state.velocities);
  EXPECT_LT(p.state.velocities.norm(), 0.1 * given);
  EXPECT_GT(p.state.velocities.norm(), 0);
  Points impulses = Points::Zero(p.cloth.num_points(), 3);
  p.contacts.add_impulses(impulses);
  const Points moves = impulses.array().colwise() * p.cloth.inv_mass.array();
  EXPECT_LT((moves - p.state.velocities).norm(), 1e-12) << "velocities are what impulses gave";
}

}  // namespace
}  // namespace clothsim::surface_contacts_test
