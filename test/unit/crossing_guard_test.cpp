#include "clothsim/constraints/crossing_guard.h"

#include <vector>

#include "clothsim/constraints/self_contacts.h"
#include "clothsim/geometry/intersections.h"
#include "surface_testing.h"

namespace clothsim::crossing_guard_test {
namespace {

using namespace test;

constexpr double displacement_factor = 0.5;
constexpr double h = 1e-3;
constexpr double thickness = strip_thickness;
const Workers alone;

TEST(CrossingGuard, LetsNothingCrossWhateverMovesThePoints) {
  ClothSpec spec;
  spec.columns = spec.rows = 9;
  spec.thickness = thickness;
  const Cloth cloth = make_grid(spec);
  for (const double origin : {0.0, 1e3}) {  // far away, rounding hides the directions of contacts
    int held = 0;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      SelfContacts contacts(cloth, SelfCollision::surface);
      State state{cloth.rest_positions.array() + origin, Points::Zero(81, 3), 0};
      for (std::uint64_t k = 0; k < 60; ++k) {
        // All points are drawn to one place, by far too much at once.
        const Points start = state.positions;
        state.positions = 0.8 * (start.array() - origin) + origin;
        state.positions += random_points(81, 0.02, 1000 * seed + k);
        const ContactStep contact_step{h, displacement_factor, start, state.velocities, alone};
        contacts.prepare(cloth, contact_step, state);
        const Points by_impulses = start + random_points(81, 0.05, 2000 * seed + k);
        held += contacts.guard(cloth, contact_step, by_impulses, state);
        ASSERT_EQ(count_intersections(cloth, state.positions), 0)
            << origin << ' ' << seed << ' ' << k;
      }
    }
    EXPECT_GT(held, 0);
  }
}

TEST(CrossingGuard, LetsPartWhatIsAsNearAsItMayCome) {
  const Cloth cloth = strip(8);
  State state = folded(cloth, 2.1 * thickness, Eigen::RowVector3d(0.031, 0.007, 0));
  SelfContacts contacts(cloth, SelfCollision::surface);
  const auto move_end = [&](double way) {
    const Points start = state.positions;
    for (const int i : {6, 7, 14, 15}) state.positions(i, 2) += way;
    const ContactStep contact_step{h, displacement_factor, start, state.velocities, alone};
    contacts.prepare(cloth, contact_step, state);
    contacts.guard(cloth, contact_step, Points(state.positions), state);
    ASSERT_EQ(count_intersections(cloth, state.positions), 0);
  };
  for (int i = 0; i < 60; ++i) move_end(-thickness);
  EXPECT_LT(min_distance(cloth, state.positions), 1e-4 * thickness);
  move_end(thickness);
  EXPECT_GT(min_distance(cloth, state.positions), 0.1 * thickness) << "at once";
  for (int i = 0; i < 5; ++i) move_end(thickness);
  EXPECT_GT(min_distance(cloth, state.positions), thickness);
}

TEST(CrossingGuard, LetsLayersTurnThatAreAsNearAsTheyMayCome) {
  const Cloth cloth = strip(8);
  State state = folded(cloth, 2.1 * thickness, Eigen::RowVector3d(0.031, 0.007, 0));
  SelfContacts contacts(cloth, SelfCollision::surface);
  const auto go_to = [&](const Points& ends) {
    const Points start = state.positions;
    state.positions = ends;
    const ContactStep contact_step{h, displacement_factor, start, state.velocities, alone};
    contacts.prepare(cloth, contact_step, state);
    return contacts.guard(cloth, contact_step, Points(ends), state);
  };
  for (int i = 0; i < 60; ++i) {
    Points ends = state.positions;
    for (const int k : {6, 7, 14, 15}) ends(k, 2) -= thickness;
    go_to(ends);
  }
  const double least = min_distance(cloth, state.positions);
  EXPECT_LT(least, 1e-4 * thickness);
  // Corners move many times that distance across the layers.
  for (const Vector3& axis : {Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(1, 2, -1)}) {
    const Eigen::Matrix3d turn(Eigen::AngleAxisd(4e-3, axis.normalized()));
    for (int i = 0; i < 100; ++i) {
      const Points ends = state.positions * turn.transpose();
      ASSERT_EQ(go_to(ends), 0) << i;
      ASSERT_EQ(state.positions, ends);
    }
    EXPECT_NEAR(min_distance(cloth, state.positions), least, 1e-4 * least);
    EXPECT_EQ(count_intersections(cloth, state.positions), 0);
  }
}

TEST(CrossingGuard, WhatItHoldsBackGoesAlongWithWhatCollidersHold) {
  const Cloth cloth = strip(8);
  const State at_start = folded(cloth, 2.1 * thickness, Eigen::RowVector3d(0.031, 0.007, 0));
  std::vector<char> held(static_cast<std::size_t>(cloth.num_points()), 0);
  for (const std::size_t i : {6, 7, 14, 15}) held[i] = 1;
  for (const bool any_held : {false, true}) {
    State state = at_start;
    // The upper layer goes through the lower one.
    const Eigen::RowVector3d way(0.01, 0, -5 * thickness);
    for (const int i : {6, 7, 14, 15}) state.positions.row(i) += way;
    ContactStep contact_step{h, displacement_factor, at_start.positions, state.velocities, alone};
    if (any_held) contact_step.pinched = &held;
    SelfContacts contacts(cloth, SelfCollision::surface);
    contacts.prepare(cloth, contact_step, state);
    EXPECT_GT(contacts.guard(cloth, contact_step, Points(state.positions), state), 0);
    EXPECT_EQ(count_intersections(cloth, state.positions), 0);
    for (const int i : {6, 7, 14, 15}) {
      const double off =
          (state.positions.row(i) - at_start.positions.row(i) - way).norm() / way.norm();
      EXPECT_EQ(off < 1e-12, any_held) << i << ' ' << off;
    }
  }
}

TEST(CrossingGuard, WhatItHoldsBackGoesAlongWithWhatItTouchesAlone) {
  // The end of a strip, turned back onto the strip.
  const Cloth cloth = strip(30);
  State at_start{cloth.rest_positions, Points::Zero(cloth.num_points(), 3), 0};
  const std::vector<int> end{28, 29, 58, 59}, below{23, 24, 25, 53, 54, 55}, far{5, 35};
  for (const int i : end) {
    const double x = cloth.rest_positions(25, 0) - cloth.rest_positions(i % 30 - 28, 0) + 0.031;
    at_start.positions.row(i) << x, i < 30 ? 0.02 : 0.08, 2.1 * thickness;
  }
  // The end goes through the layer below, while the strip's other end stays or goes elsewhere.
  const auto guarded = [&](double way_of_far) -> Points {
    State state = at_start;
    for (const int i : end) state.positions(i, 2) -= 5 * thickness;
    for (const int i : far) state.positions(i, 1) += way_of_far;
    const ContactStep contact_step{h, displacement_factor, at_start.positions, state.velocities,
                                   alone};
    SelfContacts contacts(cloth, SelfCollision::surface);
    contacts.prepare(cloth, contact_step, state);
    EXPECT_GT(contacts.guard(cloth, contact_step, Points(state.positions), state), 0);
    EXPECT_EQ(count_intersections(cloth, state.positions), 0);
    return state.positions;
  };
  const Points as_far_stays = guarded(0), as_far_goes = guarded(0.03);
  for (const std::vector<int>& points : {end, below}) {
    for (const int i : points) EXPECT_EQ(as_far_goes.row(i), as_far_stays.row(i)) << i;
  }
  EXPECT_LT(as_far_stays(24, 2), -thickness / 2) << "goes along";
}

TEST(CrossingGuard, LeavesOutRepairsThatHoldTogetherWhatTouches) {
  const Cloth cloth = strip(8);
  State state = folded(cloth, 2.1 * thickness, Eigen::RowVector3d(0.031, 0.007, 0));
  SelfContacts contacts(cloth, SelfCollision::surface);
  const auto move_corner = [&](double by_impulses, double by_repairs) {
    const Points start = state.positions;
    state.positions(7, 2) += by_impulses;
    const Points before_repairs = state.positions;
    state.positions(7, 2) += by_repairs;
    const ContactStep contact_step{h, displacement_factor, start, state.velocities, alone};
    contacts.prepare(cloth, contact_step, state);
    contacts.guard(cloth, contact_step, before_repairs, state);
    ASSERT_EQ(count_intersections(cloth, state.positions), 0);
  };
  for (int i = 0; i < 60; ++i) move_corner(0, -thickness);
  EXPECT_LT(min_distance(cloth, state.positions), 1e-4 * thickness);
  move_corner(thickness, -2 * thickness);
  EXPECT_GT(min_distance(cloth, state.positions), 0.1 * thickness);
}

TEST(CrossingGuard, HoldsNothingBackThatMovesTogether) {
  const Cloth cloth = strip(8);
  State state = folded(cloth, 2.1 * thickness, Eigen::RowVector3d(0.031, 0.007, 0));
  const Points start = state.positions;
  state.positions.rowwise() += Eigen::RowVector3d(1, 2, 3);
  const Points target = state.positions;
  SelfContacts contacts(cloth, SelfCollision::surface);
  const ContactStep contact_step{h, displacement_factor, start, state.velocities, alone};
  contacts.prepare(cloth, contact_step, state);
  EXPECT_EQ(contacts.guard(cloth, contact_step, Points(state.positions), state), 0);
  EXPECT_EQ(state.positions, target);
}

}  // namespace
}  // namespace clothsim::crossing_guard_test
