// Cloths dropped on rims and edges, checked without the code of contact: their triangles are
// sampled densely, in every frame.

#include <cmath>

#include "clothsim/run/driven_frames.h"
#include "meshes.h"
#include "verification/testing.h"

namespace clothsim::solids_test {
namespace {

using namespace test;

/// Depth in the solid of the deepest of all points of the triangles on a lattice [m]; negative
/// where they are outside. Triangles farther away than their size are left out.
double deepest_sample(const Simulator& simulator, int index) {
  constexpr int along = 8;
  const Shape& shape = simulator.scene().colliders[static_cast<std::size_t>(index)].shape;
  const Pose& pose = simulator.collider_pose(index);
  const Points& x = simulator.state().positions;
  const auto local = [&](int i) { return to_local(pose, x.row(i).transpose()); };
  const auto depth = [&](const Vector3& p) { return -signed_distance(shape, p, p).value; };
  double deepest = -1;
  for (const auto& [i, j, k] : simulator.cloth().triangles) {
    const Vector3 a = local(i), u = local(j) - a, v = local(k) - a;
    if (depth(a) < -std::max(u.norm(), v.norm())) continue;
    for (int m = 0; m <= along; ++m) {
      for (int n = 0; m + n <= along; ++n) {
        deepest = std::max(deepest, depth(a + (m * u + n * v) / along));
      }
    }
  }
  return deepest;
}

Scene above(const Shape& shape, const Pose& pose, int side = 30) {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = side;
  ColliderSpec solid;
  solid.name = "solid";
  solid.shape = shape;
  solid.pose = pose;
  solid.friction = 0.4;
  scene.colliders = {solid};
  return scene;
}

/// A fabric that falls on the shape with its top at a height of 0 and bends over its rim.
Scene fabric_over(const Shape& shape, double half_height) {
  Scene scene = above(shape, {Vector3(0, 0, -half_height)}, 24);
  scene.cloth.width = scene.cloth.height = 0.2;
  scene.cloth.origin = {-0.1, -0.1, 2e-3};
  scene.cloth.material.fabric = Fabric{{600, 450}, 25, {2.5e-5, 1.8e-5}, {1e-5, 4e-3}};
  scene.cloth.material.density = 0.15;
  scene.cloth.material.strain_limit.reset();
  scene.cloth.thickness = 5e-4;
  return scene;
}

Pose turned(const Vector3& position, double angle, const Vector3& axis) {
  return {position, Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized()))};
}

/// A pose of the shape within a frame that turns, as for a mesh on a link.
TEST(PoseInFrame, MovesWithTheFrame) {
  Scene scene = above(Cylinder{0.3, 0.05}, {Vector3(0, 0, 2)});
  ColliderSpec& solid = scene.colliders[0];
  solid.frame = "link";
  solid.offset = turned({0.2, 0, 0.1}, M_PI / 2, {0, 1, 0});
  Simulator simulator(scene);
  const auto expect_at = [&](const Vector3& position, const Vector3& axis) {
    const Pose& pose = simulator.collider_pose(0);
    EXPECT_LT((pose.position - position).norm(), 1e-12);
    EXPECT_LT((pose.orientation * Vector3::UnitZ() - axis).norm(), 1e-12);
  };
  expect_at({0.2, 0, 2.1}, Vector3::UnitX());
  const Pose frame = turned({0, 0, 2}, M_PI / 2, {0, 0, 1});
  simulator.move_collider(0, frame);
  simulator.step();
  expect_at({0, 0.2, 2.1}, Vector3::UnitY());
  const auto followed = followed_pose("link", simulator);
  ASSERT_TRUE(followed);
  EXPECT_LT((followed->position - frame.position).norm(), 1e-12);
  EXPECT_LT(followed->orientation.angularDistance(frame.orientation), 1e-7);
  simulator.place_collider(0, {Vector3(1, 1, 3)});
  expect_at({1.2, 1, 3.1}, Vector3::UnitX());
  simulator.reset();
  expect_at({0.2, 0, 2.1}, Vector3::UnitX());
}

TEST(FabricOnARim, MovesAsIfEachSubstepRanDetection) {
  struct Case {
    Shape shape;
    double half_height;
    double apart;  // at most, of the way
  };
  // On the rim of the cylinder one substep more or less makes a difference of 0.025.
  const std::vector<Case> cases = {{Cylinder{0.1, 0.06}, 0.05, 0.02},
                                   {Cuboid{{0.12, 0.1, 0.1}}, 0.05, 1e-3},
                                   {Capsule{0.1, 0.01}, 0.06, 0.01},
                                   {mesh_shape(step_soup(0.1)), 0.05, 0.01}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.shape.index());
    Scene scene = fabric_over(c.shape, c.half_height);
    scene.simulation.method = "verlet";
    Simulator skipping(scene);
    // A named number of substeps makes each one run detection.
    scene.simulation.substeps = skipping.step().substeps;
    Simulator detecting(scene);
    detecting.step();
    double apart = 0;
    for (int frame = 1; frame < 30; ++frame) {
      skipping.step();
      detecting.step();
      apart = std::max(
          apart, longest_displacement(skipping.state().positions, detecting.state().positions));
    }
    const double moved =
        longest_displacement(skipping.state().positions, skipping.cloth().rest_positions);
    EXPECT_GT(moved, 0.04) << "it bends down";
    EXPECT_LT(apart, c.apart * moved);
  }
}

/// What a cloth keeps of a mesh between steps saves time and changes nothing.
TEST(FabricOnARim, MovesTheSameAfterItsStateIsSetElsewhere) {
  for (const Shape& shape : {mesh_shape(step_soup(0.1)), mesh_shape(ball_soup(0.06, 14, 7), 1e-3),
                             Shape(Cylinder{0.1, 0.06})}) {
    SCOPED_TRACE(shape.index());
    Scene scene = fabric_over(shape, 0.055);
    scene.simulation.method = "verlet";
    Simulator straight(scene);
    for (int frame = 0; frame < 40; ++frame) {
      straight.step();
      if (frame % 2 != 1) continue;
      Simulator other(scene);
      other.set_state(straight.state(), straight.memory());
      other.step();
      straight.step();
      ASSERT_EQ(other.state().positions, straight.state().positions) << frame;
      ASSERT_EQ(other.state().velocities, straight.state().velocities) << frame;
    }
    EXPECT_GT(straight.step().contacts, 10);
  }
}

/// Colliders out of a frame's reach are skipped. (Faster ones than these tear the cloth from its
/// pins.)
TEST(OutOfReach, ACollidersTouchIsNotMissedHoweverFastItComes) {
  for (const double speed : {5.0, 20.0}) {
    Scene scene = above(Sphere{0.2}, {Vector3(0.5, 0.5, -4)});
    scene.cloth.pinned = {{0, 0, ""}, {29, 0, ""}, {0, 29, ""}, {29, 29, ""}};
    Simulator simulator(scene);
    Pose pose = simulator.collider_pose(0);
    const double dt = simulator.frame_duration();
    int touching = 0;
    for (int frame = 0; pose.position.z() < 1.0; ++frame) {
      pose.position.z() += speed * dt;
      simulator.move_collider(0, pose);
      if (simulator.step().contacts > 0) ++touching;
      ASSERT_LT(deepest_sample(simulator, 0), surface_offset) << frame;
    }
    EXPECT_GT(touching, 0) << speed;
  }
}

TEST(OutOfReach, AHangingClothIsAsWithoutThemAndGoesOnToTheSameBits) {
  Scene scene = above(Sphere{0.2}, {Vector3(0.5, 0.5, -20)});
  scene.cloth.pinned = {{0, 0, ""}, {29, 0, ""}};
  Scene alone = scene;
  alone.colliders.clear();
  Simulator first(scene), without(alone);
  run(first, 4);
  run(without, 4);
  EXPECT_LT((first.state().positions - without.state().positions).rowwise().norm().maxCoeff(),
            2e-3);
  // Also through the frames in which it comes within reach.
  Simulator second(scene);
  second.set_state(first.state(), first.memory());
  for (Simulator* simulator : {&first, &second}) {
    simulator->place_collider(0, {Vector3(0.5, 0.5, -1.5)});
    for (int frame = 0; frame < 40; ++frame) {
      simulator->move_collider(0, {Vector3(0.5, 0.5, -1.5 + 0.05 * frame)});
      simulator->step();
    }
  }
  EXPECT_EQ(first.state().positions, second.state().positions);
  EXPECT_EQ(first.state().velocities, second.state().velocities);
}

TEST(OutOfReach, APinPulledFartherThanThoughtIsFollowedWithoutARecovery) {
  Scene scene = above(Sphere{0.2}, {Vector3(0.5, 0.5, -0.5)});
  scene.cloth.pinned = {{0, 0, ""}, {29, 0, ""}, {0, 29, ""}, {29, 29, ""}};
  scene.cloth.material.strain_limit.reset();
  Simulator simulator(scene);
  run(simulator, 0.2);
  int recoveries = 0;
  for (int frame = 0; frame < 40; ++frame) {
    for (int pin = 0; pin < 4; ++pin) {
      Vector3 target = simulator.state().positions.row(pin % 2 * 29 + pin / 2 * 870).transpose();
      target.z() -= frame == 10 ? 0.3 : 0.0;  // 27 m/s at once
      simulator.move_pin(pin, target);
    }
    recoveries += simulator.step().recoveries;
    ASSERT_LT(deepest_sample(simulator, 0), surface_offset) << frame;
  }
  EXPECT_EQ(recoveries, 0);
}

TEST(OutOfReach, WhatNothingMovesIsLeftAlone) {
  Scene scene = above(Plane{}, {});
  scene.cloth.origin = {0, 0, 1};
  scene.simulation.gravity = Vector3::Zero();
  Simulator simulator(scene);
  for (int frame = 0; frame < 20; ++frame) EXPECT_EQ(simulator.step().recoveries, 0);
  EXPECT_LT(simulator.state().velocities.cwiseAbs().maxCoeff(), 1e-9);
}

TEST(OnAnOctahedron, AFreeThinClothKeepsItsStrainLimit) {
  struct Case {
    double ks, density;
  };
  for (const Case& c : {Case{1000, 0.2}, Case{300, 3}, Case{5000, 150}}) {
    Scene scene =
        above(mesh_shape(ball_soup(0.15, 4, 2)), turned({0.5, 0.5, 0}, 0.3, {1, 0.4, 0}), 56);
    scene.cloth.origin = {-0.05, 0.03, 0.4};
    scene.cloth.thickness = 1.75e-4;
    scene.cloth.material.ks = c.ks;
    scene.cloth.material.density = c.density;
    Simulator simulator(scene);
    double worst = 0;
    for (int frame = 0; frame < 60; ++frame) {
      worst = std::max(worst, simulator.step().worst_stretch);
    }
    EXPECT_GT(worst, 0.02) << c.ks << ", it has touched";
    EXPECT_LT(worst, 0.11) << c.ks;
  }
}

/// A stand-off of 0.1 mm allows the same depth.
constexpr double tolerance = surface_offset;

struct Drop {
  const char* name;
  Scene scene;
};

void PrintTo(const Drop& drop, std::ostream* out) { *out << drop.name; }

class DroppedOn : public ::testing::TestWithParam<Drop> {};

TEST_P(DroppedOn, NoPointOfATriangleIsInTheSolidInAnyFrame) {
  Simulator simulator(GetParam().scene);
  double deepest = -1;
  for (int frame = 0; frame < 180; ++frame) {
    ASSERT_EQ(simulator.step().recoveries, 0) << frame;
    const double now = deepest_sample(simulator, 0);
    deepest = std::max(deepest, now);
    ASSERT_LT(now, tolerance) << frame;
  }
  RecordProperty("deepest_um", std::to_string(1e6 * deepest));
  EXPECT_GT(deepest, -1e-3) << "it has never touched";
}

const Drop drops[] = {
    {"end_of_a_drum", above(Cylinder{0.3, 0.25}, {Vector3(0.5, 0.5, 0.7)})},
    {"rim_of_a_leaning_drum",
     above(Cylinder{0.3, 0.25}, turned({0.5, 0.5, 0.6}, 0.8, {1, 0.3, 0}))},
    {"thin_disc_on_edge", above(Cylinder{0.01, 0.3}, turned({0.5, 0.5, 0.6}, M_PI / 2, {1, 0, 0}))},
    {"end_of_a_rod_within_a_cell", above(Cylinder{0.6, 0.008}, {Vector3(0.51, 0.49, 0.6)})},
};

const Drop mesh_drops[] = {
    {"edge_of_a_box",
     above(mesh_shape(box_soup({0.4, 0.4, 0.3})), turned({0.5, 0.5, 0.6}, 0.7, {1, 0.3, 0}))},
    {"inner_corner_of_a_step", above(mesh_shape(step_soup(0.4)), {Vector3(0.5, 0.5, 0.6)})},
    {"finger_upside_down",
     above(mesh_shape(finger_soup()), turned({0.51, 0.49, 0.9}, M_PI, {1, 0, 0}))},
    {"ball_of_facets", above(mesh_shape(globe_soup(0.2, 6)), {Vector3(0.5, 0.5, 0.6)})},
    {"square_sheet",
     above(sheet_shape(square_soup(0.4), 0.004), turned({0.5, 0.5, 0.8}, 0.3, {1, 0.3, 0}))},
    {"sheet_on_edge",
     above(sheet_shape(square_soup(0.4), 0.004), turned({0.5, 0.5, 0.6}, 1.5, {1, 0.3, 0}))},
    {"bowl", above(sheet_shape(above_z(globe_soup(0.3, 4), 0.05), 0.004),
                   turned({0.5, 0.5, 0.9}, M_PI, {1, 0, 0}))},
};

INSTANTIATE_TEST_SUITE_P(Meshes, DroppedOn, ::testing::ValuesIn(mesh_drops),
                         [](const auto& test) { return test.param.name; });

INSTANTIATE_TEST_SUITE_P(Shapes, DroppedOn, ::testing::ValuesIn(drops),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace clothsim::solids_test
