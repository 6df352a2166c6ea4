// Cloths on colliders of all shapes: no cloth gets inside, and cloth that lies comes to rest.

#include <cmath>

#include "clothsim/dynamics/energy.h"
#include "clothsim/geometry/intersections.h"
#include "clothsim/run/report.h"
#include "scene/collider_scenes.h"
#include "verification/testing.h"

namespace clothsim::colliders_test {
namespace {

using namespace test;

const Vector3 lying_along_y(M_PI / 2, 0, 0);  // of an axis that is z in its own frame

/// One frame, with all checks after it.
void step_checked(Simulator& simulator, double speed_limit) {
  const StepReport report = simulator.step();
  ASSERT_EQ(report.recoveries, 0) << simulator.state().time;
  ASSERT_TRUE(simulator.state().positions.allFinite()) << simulator.state().time;
  ASSERT_LT(max_speed(simulator.state()), speed_limit) << simulator.state().time;
  ASSERT_EQ(deepest_penetration(simulator), 0) << simulator.state().time;
}

// ---- Dropped on an edge, a rod and balls

struct Drop {
  const char* name;
  int side;  // points of the cloth along a side
  std::vector<ColliderSpec> colliders;
};

const Drop drops[] = {
    {"box_edge", 25, {{"table", Cuboid{{1, 1.4, 0.3}}, pose_at({0.1, 0.5, 0.6}), 0.5, ""}}},
    {"box_corner",
     25,
     {{"crate", Cuboid{{0.5, 0.5, 0.5}}, pose_at({0.5, 0.5, 0.4}, {0.7, 0.5, 0}), 0.5, ""},
      {"ground", Plane{}, pose_at({0, 0, 0}), 0.5, ""}}},
    {"capsule",
     25,
     {{"rod", Capsule{1.4, 0.03}, pose_at({0.5, 0.5, 0.6}, lying_along_y), 0.5, ""}}},
    {"cylinder_rim", 25, {{"drum", Cylinder{0.3, 0.25}, pose_at({0.5, 0.5, 0.6}), 0.5, ""}}},
    {"three_spheres",
     25,
     {{"a", Sphere{0.1}, pose_at({0.25, 0.3, 0.6}), 0.5, ""},
      {"b", Sphere{0.1}, pose_at({0.75, 0.3, 0.6}), 0.5, ""},
      {"c", Sphere{0.1}, pose_at({0.5, 0.75, 0.6}), 0.5, ""},
      {"ground", Plane{}, pose_at({0, 0, 0}), 0.5, ""}}},
};

struct Stuff {
  double ks, density;
};

class Dropped : public ::testing::TestWithParam<std::tuple<Drop, Stuff>> {};

/// Steps half a second and checks each frame. Returns the root mean square velocity in it.
double half_a_second(Simulator& simulator) {
  double sum = 0;
  for (int frame = 0; frame < 45; ++frame) {
    step_checked(simulator, 20);
    if (::testing::Test::HasFatalFailure()) return 0;
    const int crossing = count_intersections(simulator.cloth(), simulator.state().positions);
    EXPECT_EQ(crossing, 0) << simulator.state().time;
    if (crossing > 0) return 1;
    sum += std::pow(rms_velocity(simulator.state()), 2) / 45;
  }
  return std::sqrt(sum);
}

TEST_P(Dropped, LiesStillOutsideWithAllItsTrianglesAndCrossesNothing) {
  const auto& [drop, stuff] = GetParam();
  Scene scene = with_colliders(drop.colliders, drop.side);
  scene.cloth.material.ks = stuff.ks;
  scene.cloth.material.density = stuff.density;
  scene.cloth.self_collision = SelfCollision::surface;
  Simulator simulator(scene);

  const double calm = 1e-3;  // [m/s]
  // On small balls a soft cloth's corner slips off one after six seconds.
  double speed = half_a_second(simulator);
  while ((speed > calm || simulator.state().time < 3) && simulator.state().time < 9) {
    speed = half_a_second(simulator);
    if (HasFailure()) return;
  }
  RecordProperty("at_rest_after_s", std::to_string(simulator.state().time));
  RecordProperty("mm_s", std::to_string(1e3 * speed));
  EXPECT_LT(speed, calm);
}

std::string name_of(const ::testing::TestParamInfo<std::tuple<Drop, Stuff>>& info) {
  const auto& [drop, stuff] = info.param;
  return std::string(drop.name) + "_ks_" + std::to_string(static_cast<int>(stuff.ks)) +
         "_density_" + std::to_string(static_cast<int>(stuff.density));
}

INSTANTIATE_TEST_SUITE_P(Scenes, Dropped,
                         ::testing::Combine(::testing::ValuesIn(drops),
                                            ::testing::Values(Stuff{50, 150}, Stuff{5000, 150},
                                                              Stuff{100000, 150}, Stuff{5000, 10},
                                                              Stuff{5000, 1}, Stuff{5000, 10000})),
                         name_of);

TEST(Colliders, ABoxesDrapeRestsWithinItsLimit) {
  // Below the box's corners the limit holds springs that its edges stretch in the same step.
  for (const int side : {25, 30, 50}) {
    Simulator simulator(with_colliders(
        {{"box", Cuboid{{0.4, 0.4, 0.4}}, pose_at({0.5, 0.5, 0.4}), 0.3, ""}}, side));
    double stretch = 0;
    for (int frame = 0; frame < 8 * 90; ++frame) {
      stretch = std::max(stretch, simulator.step().worst_stretch);
    }
    EXPECT_LT(max_speed(simulator.state()), 1e-3) << side;
    EXPECT_LT(stretch, 0.1125) << side;
  }
}

TEST(Colliders, GoOnToTheSameBitsFromAStateAndItsMemory) {
  for (const Drop& drop : drops) {
    const Scene scene = with_colliders(drop.colliders);
    Simulator first(scene);
    run(first, 0.7);
    Simulator second(scene);
    second.set_state(first.state(), first.memory());
    run(first, 0.3);
    run(second, 0.3);
    EXPECT_EQ(first.state().positions, second.state().positions) << drop.name;
    EXPECT_EQ(first.state().velocities, second.state().velocities) << drop.name;
  }
}

// ---- Driven through a hanging cloth

/// Speed [m/s], and density of the cloth [kg/m^2].
class Driven : public ::testing::TestWithParam<std::tuple<double, double>> {
 protected:
  const double speed = std::get<0>(GetParam());

  static Scene hanging(const std::vector<ColliderSpec>& colliders) {
    Scene scene = hanging_with(colliders);
    scene.cloth.material.density = std::get<1>(GetParam());
    return scene;
  }

  /// Lets the cloth hang, then moves the collider 1.5 m along y from y = `from`.
  void drive(Simulator simulator, double from, const Vector3& turn) const {
    for (int frame = 0; frame < 270; ++frame) step_checked(simulator, 20);
    if (HasFatalFailure()) return;
    const int frames = static_cast<int>(std::ceil(1.5 * 90 / speed));
    for (int frame = 1; frame <= frames; ++frame) {
      simulator.move_collider(0, pose_at({0.5, from + 1.5 * frame / frames, 0.5}, turn));
      step_checked(simulator, 10 * speed + 20);
      if (HasFatalFailure()) return;
    }
  }
};

TEST_P(Driven, AThinRodStaysOutOfTheTriangles) {
  // Thinner than the cloth's spacing of 42 mm: it could pass between the points.
  const ColliderSpec rod{"rod", Capsule{0.6, 0.005}, pose_at({0.5, -0.3, 0.8}), 0.3, ""};
  drive(Simulator(hanging({rod})), -0.3, lying_along_y);
}

TEST_P(Driven, ABoxCornerStaysOutOfTheTriangles) {
  const Vector3 turn(0.6, 0.5, 0.3);
  const ColliderSpec box{"box", Cuboid{{0.3, 0.3, 0.3}}, pose_at({0.5, -0.5, 0.5}, turn), 0.3, ""};
  drive(Simulator(hanging({box})), -0.5, turn);
}

INSTANTIATE_TEST_SUITE_P(Speeds, Driven,
                         ::testing::Combine(::testing::Values(1.0, 10.0, 100.0),
                                            ::testing::Values(150.0, 0.3)));

class Turning : public ::testing::TestWithParam<double> {};

TEST_P(Turning, ABarSweepsTheClothAside) {
  // The bar turns about its middle beside the cloth; its end comes through the place of the cloth.
  const double w = GetParam();  // [rad/s]
  const auto at = [](double angle) { return pose_at({0.5, -0.3, 0.6}, {M_PI / 2 + angle, 0, 0}); };
  Simulator simulator(hanging_with({{"bar", Capsule{0.8, 0.02}, at(-M_PI / 2), 0.3, ""}}));
  for (int frame = 0; frame < 270; ++frame) step_checked(simulator, 20);
  if (HasFatalFailure()) return;
  const int frames = static_cast<int>(std::ceil(M_PI / w * 90));
  for (int frame = 1; frame <= frames; ++frame) {
    simulator.move_collider(0, at(M_PI * (1.0 * frame / frames - 0.5)));
    step_checked(simulator, 5 * w + 20);
    if (HasFatalFailure()) return;
  }
}

INSTANTIATE_TEST_SUITE_P(Rates, Turning, ::testing::Values(1.0, 10.0, 100.0));

// ---- Put into the cloth

struct Put {
  const char* name;
  Shape shape;
  Vector3 turn;
};

class PutInto : public ::testing::TestWithParam<Put> {};

/// Largest velocity of a point out of a shape that is put into a taut cloth [m/s].
constexpr double max_speed_out = 10;

/// Runs until the cloth is out of the collider; returns the time [s].
double time_to_leave(Simulator& simulator) {
  for (int frame = 1; frame <= 90; ++frame) {
    const StepReport report = simulator.step();
    EXPECT_EQ(report.recoveries, 0) << frame;
    EXPECT_TRUE(simulator.state().positions.allFinite()) << frame;
    EXPECT_LT(max_speed(simulator.state()), max_speed_out) << frame;
    if (deepest_penetration(simulator) == 0) return frame / 90.0;
  }
  return 10;
}

TEST_P(PutInto, AHangingClothComesOutAtABoundedSpeed) {
  for (const double depth : {-0.1, 0.0, 0.001, 0.07}) {
    Simulator simulator(hanging_with({{"it", GetParam().shape, pose_at({0, 0, 5}), 0.3, ""}}));
    for (int frame = 0; frame < 270; ++frame) simulator.step();
    const Vector3 middle = point(simulator.cloth(), simulator.state().positions, 12, 12);
    simulator.place_collider(0, pose_at(middle + Vector3(0, depth, 0), GetParam().turn));
    const double t = time_to_leave(simulator);
    RecordProperty("seconds_at_" + std::to_string(depth), std::to_string(t));
    EXPECT_LT(t, 0.5) << depth;
    for (int frame = 0; frame < 90; ++frame) {
      step_checked(simulator, max_speed_out);
      if (HasFatalFailure()) return;
    }
  }
}

TEST(RodPutInto, HardlyEverFlingsATautClothWhereverItIs) {
  // Where the middle of the rod lies in the cloth, the ways out to both sides are equal. There a
  // point is flung for a frame at a few depths.
  const Vector3 turn(0, 1.57, 0.2);
  Simulator simulator(hanging_with({{"rod", Capsule{0.6, 0.02}, pose_at({0, 0, 5}), 0.3, ""}}));
  for (int frame = 0; frame < 270; ++frame) simulator.step();
  const Vector3 middle = point(simulator.cloth(), simulator.state().positions, 12, 12);
  const auto hanging = simulator.save();
  int flung = 0;
  for (int depth = -30; depth < 30; ++depth) {  // [mm]
    simulator.restore(*hanging);
    simulator.place_collider(0, pose_at(middle + Vector3(0, 1e-3 * depth, 0), turn));
    double fast = 0;
    for (int frame = 0; frame < 4; ++frame) {
      simulator.step();
      fast = std::max(fast, max_speed(simulator.state()));
    }
    EXPECT_LT(fast, max_speed_out) << depth;
    flung += fast > 3.5;
  }
  EXPECT_LE(flung, 3) << "of 60";
}

TEST(CapsulePutInto, DoesNotSendAStripToAndFro) {
  // Below the pinned row the other row lies about the capsule's middle: both sides are equally
  // near.
  Scene scene = with_colliders({{"it", Capsule{0.082, 0.061}, pose_at({0.18, 0.003, 1.0}), 0, ""}});
  scene.cloth.columns = 14;
  scene.cloth.rows = 2;
  scene.cloth.width = 0.359;
  scene.cloth.height = 0.0142;
  scene.cloth.orientation = Orientation::vertical;
  scene.cloth.thickness = 1e-3;
  scene.cloth.material.ks = 385;
  scene.cloth.material.density = 4.25;
  scene.cloth.material.damping = 8.4;
  scene.cloth.material.strain_limit.reset();
  for (int column = 0; column < 14; ++column) scene.cloth.pinned.push_back({column, 1, ""});
  Simulator simulator(scene);
  run(simulator, 8);
  EXPECT_LT(rms_velocity(simulator.state()), 1e-3);
}

TEST_P(PutInto, ASceneMayStartWithTheShapeInTheCloth) {
  Simulator simulator(hanging_with(
      {{"it", GetParam().shape, pose_at({0.5, 0.5, 0.97}, GetParam().turn), 0.3, ""}}));
  EXPECT_LT(time_to_leave(simulator), 0.5);
}

INSTANTIATE_TEST_SUITE_P(Shapes, PutInto,
                         ::testing::Values(Put{"sphere", Sphere{0.2}, {0, 0, 0}},
                                           Put{"small_sphere", Sphere{0.02}, {0, 0, 0}},
                                           Put{"rod", Capsule{0.6, 0.02}, {0, 1.57, 0.2}},
                                           Put{"needle", Capsule{0.3, 0.005}, {1.57, 0, 0}},
                                           Put{"box", Cuboid{{0.3, 0.2, 0.25}}, {0.2, 0.4, 0.3}},
                                           Put{"plate", Cuboid{{0.4, 0.3, 0.01}}, {0.9, 0, 0}}),
                         [](const auto& test) { return test.param.name; });

TEST(Colliders, PointsThatStandBetweenTwoHaveNoVelocity) {
  // A box is switched on through a cloth on the floor: each pushes points into the other one.
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 12;
  scene.cloth.width = scene.cloth.height = 0.4;
  scene.cloth.origin = {-0.2, -0.2, 0.1};
  scene.cloth.material.density = 1;
  scene.cloth.material.ks = 1000;
  scene.colliders = {{"box", Cuboid{{0.2, 0.2, 0.2}}, {{0.03, 0.02, 0.03}, {}}, 0.3, ""},
                     {"floor", Plane{}, {}, 0.5, ""}};
  for (ColliderSpec& collider : scene.colliders) collider.pose.orientation.setIdentity();
  scene.colliders[0].enabled = false;
  Simulator simulator(scene);
  run(simulator, 1);
  simulator.enable_collider(0, true);
  run(simulator, 1.5);
  const Points before = simulator.state().positions;
  run(simulator, 0.5);
  const double moved = (simulator.state().positions - before).rowwise().norm().maxCoeff();
  EXPECT_LT(rms_velocity(simulator.state()), 1e-3 + 10 * moved / 0.5);
}

}  // namespace
}  // namespace clothsim::colliders_test
