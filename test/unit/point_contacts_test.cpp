
#include "clothsim/constraints/self_contacts.h"
#include "verification/testing.h"

namespace clothsim::point_contacts_test {
namespace {

using namespace test;

constexpr double displacement_factor = 0.5;
const Workers alone;
constexpr double h = 1e-3;
constexpr double thickness = 0.01;  // contact at 2 cm, rest neighbours to 4 cm

/// Masses of 1 kg, 1 m apart at rest, so that none are rest neighbours.
Cloth apart(int points, double friction = 0) {
  ClothSpec spec = chain_spec(points, 1, 0);
  spec.thickness = thickness;
  spec.friction = friction;
  return make_grid(spec);
}

/// One step of contact after points have moved: begin, solve passes to convergence, move along.
void resolve(SelfContacts& contacts, const Cloth& cloth, State& state, int passes = 500) {
  const Points before = state.velocities;
  contacts.prepare(cloth, {h, displacement_factor, state.positions, state.velocities, alone},
                   state);
  for (int i = 0; i < passes && contacts.solve_pass(0, state.velocities) > 1e-14; ++i) {
  }
  state.positions += displacement_factor * h * (state.velocities - before);
}

TEST(PointContacts, HeadOnPointsStopAtTheContactDistance) {
  // Equal masses at +-v end at rest, 2 * thickness apart: restitution zero.
  const Cloth cloth = apart(2);
  State state{Points::Zero(2, 3), Points::Zero(2, 3), 0};
  state.positions(1, 0) = 0.03;
  state.velocities(0, 0) = 1;
  state.velocities(1, 0) = -1;
  SelfContacts contacts(cloth, SelfCollision::points);
  for (int step = 0; step < 40; ++step) {
    state.positions += h * state.velocities;
    resolve(contacts, cloth, state);
    EXPECT_GE(state.positions(1, 0) - state.positions(0, 0), 2 * thickness - 1e-12);
  }
  EXPECT_NEAR(state.positions(1, 0) - state.positions(0, 0), 2 * thickness, 1e-9);
  EXPECT_LT(state.velocities.norm(), 1e-9);
  EXPECT_NEAR(state.positions(0, 0) + state.positions(1, 0), 0.03, 1e-12) << "centre of mass";
}

TEST(PointContacts, AClumpKeepsItsMomentumAndLosesEnergy) {
  const Cloth cloth = apart(40, 0.4);
  State state{random_points(40, 0.03, 1), random_points(40, 1, 2), 0};
  const Eigen::RowVector3d momentum = state.velocities.colwise().sum();
  const double energy = state.velocities.squaredNorm();
  SelfContacts contacts(cloth, SelfCollision::points);
  resolve(contacts, cloth, state);
  EXPECT_GT(contacts.count(), 10);
  EXPECT_LT((state.velocities.colwise().sum() - momentum).norm(), 1e-12);
  EXPECT_LT(state.velocities.squaredNorm(), energy);
}

TEST(PointContacts, NoTouchingPairComesCloser) {
  const Cloth cloth = apart(40);
  State state{random_points(40, 0.04, 3), random_points(40, 1, 4), 0};
  SelfContacts contacts(cloth, SelfCollision::points);
  contacts.prepare(cloth, {h, displacement_factor, state.positions, state.velocities, alone},
                   state);
  const Points normals_at = state.positions;
  for (int i = 0; i < 5000; ++i) contacts.solve_pass(0, state.velocities);
  int touching = 0;
  for (int a = 0; a < 40; ++a) {
    for (int b = a + 1; b < 40; ++b) {
      const Eigen::RowVector3d d = normals_at.row(b) - normals_at.row(a);
      if (d.norm() > 2 * thickness - 2 * h) continue;  // surely overlapping, for any move in h / 2
      ++touching;
      EXPECT_GT(d.normalized().dot(state.velocities.row(b) - state.velocities.row(a)), -1e-6);
    }
  }
  EXPECT_GT(touching, 10);
}

TEST(PointContacts, FrictionStaysInCoulombsCone) {
  // A point that comes down at v on a fixed one and slides at u: the normal impulse is the mass
  // times v, friction takes at most mu times that from the sliding.
  const double mu = 0.4;
  for (const double slide : {0.1, 5.0}) {
    ClothSpec spec = chain_spec(2, 1, 0);
    spec.thickness = thickness;
    spec.friction = mu;
    spec.pinned = {{0, 0, ""}};
    const Cloth cloth = make_grid(spec);
    State state{Points::Zero(2, 3), Points::Zero(2, 3), 0};
    state.positions(1, 2) = 2 * thickness - 1e-6;
    state.velocities.row(1) << slide, 0, -1;
    SelfContacts contacts(cloth, SelfCollision::points);
    contacts.prepare(cloth, {h, 0, state.positions, state.velocities, alone}, state);
    for (int i = 0; i < 200; ++i) contacts.solve_pass(0, state.velocities);
    EXPECT_NEAR(state.velocities(1, 2), 0, 1e-9);
    EXPECT_NEAR(state.velocities(1, 0), std::max(0.0, slide - mu * 1), 1e-9);
    EXPECT_EQ(state.velocities.row(0).norm(), 0) << "the pin was pushed";
  }
}

/// Two points that overlap by half of the contact distance, after some seconds of contact alone:
/// they separate by no more than a hundredth a step, and drift on a little.
Points after_an_overlap(const Cloth& cloth) {
  State state{Points::Zero(2, 3), Points::Zero(2, 3), 0};
  state.positions(1, 0) = thickness;
  SelfContacts contacts(cloth, SelfCollision::points);
  double last = thickness;
  for (int step = 0; step < 3000; ++step) {
    state.positions += h * state.velocities;
    state.velocities *= 0.99;
    resolve(contacts, cloth, state);
    const double overlap = 2 * thickness - (state.positions.row(1) - state.positions.row(0)).norm();
    EXPECT_GT(overlap, 0.98 * last - 1e-4) << "moved at once";
    last = std::max(overlap, 0.0);
  }
  return state.positions;
}

TEST(PointContacts, LeaveRestNeighboursOut) {
  // Neighbours 3.9 cm apart at rest may come closer than 2 cm; at 4.1 cm they may not.
  for (const double spacing : {0.039, 0.041}) {
    ClothSpec spec = chain_spec(2, spacing, 0);
    spec.thickness = thickness;
    const Points x = after_an_overlap(make_grid(spec));
    const double distance = (x.row(1) - x.row(0)).norm();
    EXPECT_NEAR(distance, spacing < 0.04 ? thickness : 2 * thickness, 1e-4);
  }
}

TEST(PointContacts, WorkOffOverlapsByInverseMass) {
  ClothSpec spec = chain_spec(2, 1, 0);
  spec.thickness = thickness;
  const Points of_free = after_an_overlap(make_grid(spec));
  EXPECT_NEAR(of_free(0, 0), -thickness / 2, 1e-4);
  EXPECT_NEAR(of_free(1, 0), 1.5 * thickness, 1e-4);
  spec.pinned = {{0, 0, ""}};
  const Points of_pinned = after_an_overlap(make_grid(spec));
  EXPECT_EQ(of_pinned.row(0).norm(), 0);
  EXPECT_NEAR(of_pinned(1, 0), 2 * thickness, 1e-4);
}

TEST(PointContacts, CoincidentPointsGiveNoNan) {
  const Cloth cloth = apart(6, 0.3);
  State state{Points::Zero(6, 3), random_points(6, 1, 1), 0};
  SelfContacts contacts(cloth, SelfCollision::points);
  for (int step = 0; step < 5; ++step) {
    resolve(contacts, cloth, state);
    EXPECT_TRUE(state.positions.allFinite());
    EXPECT_TRUE(state.velocities.allFinite());
  }
}

TEST(PointContacts, ResetForgetsEverything) {
  const Cloth cloth = apart(30, 0.3);
  const State start{random_points(30, 0.05, 1), random_points(30, 1, 2), 0};
  SelfContacts used(cloth, SelfCollision::points);
  State state = start;
  resolve(used, cloth, state);
  resolve(used, cloth, state);
  used.reset();
  EXPECT_EQ(used.count(), 0);
  State again = start;
  resolve(used, cloth, again);
  State first = start;
  SelfContacts fresh(cloth, SelfCollision::points);
  resolve(fresh, cloth, first);
  EXPECT_EQ(again.velocities, first.velocities);
}

}  // namespace
}  // namespace clothsim::point_contacts_test
