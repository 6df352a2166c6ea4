// Cloth between colliders that leave it no room: it stays calm, moves with them, and is reported.

#include <algorithm>
#include <cmath>

#include "clothsim/dynamics/energy.h"
#include "clothsim/dynamics/stretch.h"
#include "clothsim/geometry/intersections.h"
#include "clothsim/run/report.h"
#include "verification/testing.h"

namespace clothsim::pinch_test {
namespace {

using namespace test;

constexpr int side = 25;

struct Finger {
  const char* name;
  Shape shape;
  double half;  // of its width [m]
};

const Finger fingers[] = {{"boxes", Cuboid{{0.06, 0.04, 0.06}}, 0.02},
                          {"small_boxes", Cuboid{{0.02, 0.02, 0.02}}, 0.01},
                          {"balls", Sphere{0.04}, 0.04}};

/// Two fingers in front of and behind a cloth that hangs from its upper corners.
class Gripper {
 public:
  Gripper(const Finger& finger, double friction, double x = 0.5, bool all_corners_held = false)
      : half_(finger.half), x_(x), simulator_(scene(finger, friction, all_corners_held)) {
    for (int frame = 0; frame < 60; ++frame) step(0.3, z_);
  }

  /// Moves to a gap [m], a height [m] and an angle about the fingers' common axis [rad].
  void go(double gap, double z, double angle, int frames) {
    const double from_gap = gap_, from_z = z_, from_angle = angle_;
    for (int frame = 1; frame <= frames; ++frame) {
      const double share = static_cast<double>(frame) / frames;
      angle_ = from_angle + share * (angle - from_angle);
      step(from_gap + share * (gap - from_gap), from_z + share * (z - from_z));
    }
  }

  void wait(int frames) { go(gap_, z_, angle_, frames); }

  const Simulator& simulator() const { return simulator_; }
  Vector3 point(int i) const { return row(simulator_.state().positions, i); }
  /// The point nearest to the place where the fingers close.
  int between() const {
    int nearest = 0;
    const Eigen::RowVector3d here(x_, 0, z_);
    (simulator_.state().positions.rowwise() - here).rowwise().norm().minCoeff(&nearest);
    return nearest;
  }
  const StepReport& report() const { return report_; }
  double max_speed_yet() const { return max_speed_yet_; }

 private:
  static Scene scene(const Finger& finger, double friction, bool all_corners_held) {
    Scene scene;
    scene.cloth.columns = scene.cloth.rows = side;
    scene.cloth.orientation = Orientation::vertical;
    scene.cloth.origin = Vector3(0, 0, 0);
    scene.cloth.pinned = {{0, side - 1, ""}, {side - 1, side - 1, ""}};
    if (all_corners_held) {
      scene.cloth.pinned.push_back({0, 0, ""});
      scene.cloth.pinned.push_back({side - 1, 0, ""});
    }
    scene.cloth.self_collision = SelfCollision::surface;
    scene.cloth.thickness = 0.005;
    scene.simulation.frames_per_second = 60;
    scene.colliders = {{"front", finger.shape, {}, friction, ""},
                       {"back", finger.shape, {}, friction, ""}};
    for (ColliderSpec& collider : scene.colliders) {
      const double y = collider.name == "front" ? -1 : 1;
      collider.pose = {Vector3(0.5, y, 0.3), Eigen::Quaterniond::Identity()};
    }
    return scene;
  }

  void step(double gap, double z) {
    gap_ = gap;
    z_ = z;
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle_, Vector3::UnitY()));
    simulator_.move_collider(0, {Vector3(x_, -half_ - gap / 2, z), turn});
    simulator_.move_collider(1, {Vector3(x_, half_ + gap / 2, z), turn});
    report_ = simulator_.step();
    EXPECT_EQ(report_.recoveries, 0);
    max_speed_yet_ = std::max(max_speed_yet_, max_speed(simulator_.state()));
  }

  double half_;
  double x_;
  double gap_ = 0.3;
  double z_ = 0.3;
  double angle_ = 0;
  Simulator simulator_;
  StepReport report_;
  double max_speed_yet_ = 0;
};

struct Grasp {
  Finger finger;
  double overlap;  // of the fingers, with the cloth between them [m]
};

void PrintTo(const Grasp& grasp, std::ostream* out) {
  *out << grasp.finger.name << ' ' << grasp.overlap;
}

class Pinch : public ::testing::TestWithParam<Grasp> {};

TEST_P(Pinch, LiftsTheClothAndLetsItGo) {
  const auto& [finger, overlap] = GetParam();
  // Small fingers close on a triangle, between its points.
  const double x = finger.half < 0.02 ? 0.485 : 0.5;
  Gripper gripper(finger, 0.5, x);
  EXPECT_EQ(gripper.report().pinched, 0);
  gripper.go(-overlap, 0.3, 0, 60);
  EXPECT_GT(gripper.report().pinched, 0);
  const int held = gripper.between();
  const Vector3 before = gripper.point(held);
  const Vector3 lifted = before + Vector3(0, 0, 0.3);
  gripper.go(-overlap, 0.6, 0, 90);
  EXPECT_LT((gripper.point(held) - lifted).norm(), 5e-3);
  gripper.wait(90);
  EXPECT_LT((gripper.point(held) - lifted).norm(), 5e-3) << "slips while it is held";
  EXPECT_LT(rms_velocity(gripper.simulator().state()), 0.05);
  EXPECT_LT(gripper.max_speed_yet(), 5) << "nothing is flung about";
  // Springs between two held points keep their length.
  EXPECT_LT(gripper.report().worst_stretch, 0.12);

  gripper.go(2, 0.6, 0, 60);
  gripper.wait(120);
  EXPECT_EQ(gripper.report().pinched, 0);
  EXPECT_EQ(gripper.report().pinched_point, -1);
  EXPECT_EQ(deepest_penetration(gripper.simulator()), 0);
  EXPECT_LT((gripper.point(held) - before).norm(), 0.02) << "as it hung before";
}

std::vector<Grasp> grasps() {
  std::vector<Grasp> all;
  for (const Finger& finger : fingers) {
    for (const double overlap : {0.0005, 0.002, 0.008}) all.push_back({finger, overlap});
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Grasps, Pinch, ::testing::ValuesIn(grasps()), [](const auto& grasp) {
  return std::string(grasp.param.finger.name) + "_overlap_" +
         std::to_string(std::lround(1e6 * grasp.param.overlap)) + "_um";
});

TEST(Pinch, TurnsWithTheWrist) {
  Gripper gripper(fingers[0], 0.5);
  gripper.go(-0.002, 0.3, 0, 60);
  gripper.go(-0.002, 0.6, 0, 90);
  const int held = gripper.between();
  const auto angle = [&] {
    const Vector3 edge = gripper.point(held + 1) - gripper.point(held);
    return std::atan2(-edge.z(), edge.x()) * 180 / M_PI;
  };
  const double before = angle();
  gripper.go(-0.002, 0.6, M_PI / 2, 90);
  EXPECT_NEAR(angle() - before, 90, 1);
}

TEST(Pinch, SlipsOutOfFingersWithoutFriction) {
  Gripper gripper(fingers[0], 0);
  gripper.go(-0.004, 0.3, 0, 60);
  const int held = gripper.between();
  const Vector3 before = gripper.point(held);
  gripper.go(-0.004, 0.7, 0, 120);
  gripper.wait(60);
  // The fingers go 0.4 m. With 5 to 40 substeps the cloth moves 1 to 21 mm.
  EXPECT_LT((gripper.point(held) - before).norm(), 0.03);
  EXPECT_LT(gripper.max_speed_yet(), 5);
}

TEST(Pinch, SlipsOutOfFingersThatPullItFromItsPins) {
  // Held at all corners, it cannot follow so far. Its springs carry many times its weight then.
  for (const double z : {0.0, -0.05, -0.07, -0.1, -0.12, -0.2}) {
    SCOPED_TRACE(z);
    Gripper gripper(fingers[0], 0.5, 0.5, true);
    gripper.go(-0.002, 0.3, 0, 60);
    gripper.go(-0.002, z, 0, 120);
    gripper.wait(180);
    EXPECT_LT(gripper.max_speed_yet(), 10);
    EXPECT_LT(gripper.report().worst_stretch, 0.15);
    EXPECT_LT(rms_velocity(gripper.simulator().state()), 0.05);
  }
}

/// Takes both sides of a cloth that hangs over a bar, 10 mm thick together, between two fingers
/// with this gap [m], and lifts it by 0.15 m. Returns the distance that the cloth moves along [m].
double lift_fold(double gap) {
  Scene scene;
  scene.cloth.width = 0.5;  // several times as wide as the fingers
  scene.cloth.columns = side / 2 + 1;
  scene.cloth.rows = side;
  scene.cloth.origin = Vector3(-0.25, -0.5, 1.1);
  scene.cloth.self_collision = SelfCollision::surface;
  scene.cloth.thickness = 0.005;
  scene.simulation.frames_per_second = 60;
  const Eigen::Quaterniond along_x(Eigen::AngleAxisd(M_PI / 2, Vector3::UnitY()));
  scene.colliders = {{"bar", Capsule{1.4, 0.03}, {Vector3(0, 0, 1), along_x}, 0.5, ""},
                     {"front", Cuboid{{0.06, 0.04, 0.06}}, {}, 0.5, ""},
                     {"back", Cuboid{{0.06, 0.04, 0.06}}, {}, 0.5, ""}};
  const auto finger = [](double y, double z) {
    return Pose{Vector3(0, y, z), Eigen::Quaterniond::Identity()};
  };
  scene.colliders[1].pose = finger(-0.5, 0.7);
  scene.colliders[2].pose = finger(0.5, 0.7);
  Simulator simulator(scene);
  int crossings = 0;
  double max_speed_yet = 0;
  const auto go = [&](double from_y, double to_y, double from_z, double to_z, int frames) {
    max_speed_yet = 0;
    for (int frame = 1; frame <= frames; ++frame) {
      const double share = static_cast<double>(frame) / frames;
      const double y = from_y + share * (to_y - from_y), z = from_z + share * (to_z - from_z);
      simulator.move_collider(1, finger(-y, z));
      simulator.move_collider(2, finger(y, z));
      simulator.step();
      crossings += count_intersections(simulator.cloth(), simulator.state().positions);
      max_speed_yet = std::max(max_speed_yet, max_speed(simulator.state()));
    }
  };
  const auto between = [&](double z) {
    int nearest = 0;
    const Eigen::RowVector3d here(0, 0, z);
    (simulator.state().positions.rowwise() - here).rowwise().norm().minCoeff(&nearest);
    return nearest;
  };
  const double closed = 0.02 + gap / 2;
  go(0.5, 0.5, 0.7, 0.7, 180);
  go(0.5, closed, 0.7, 0.7, 90);
  go(closed, closed, 0.7, 0.7, 120);
  constexpr double calm = 0.02;  // [m/s]
  EXPECT_LT(rms_velocity(simulator.state()), calm);
  const int held = between(0.7);
  const double before = simulator.state().positions(held, 2);
  go(closed, closed, 0.7, 0.85, 60);
  EXPECT_LT(max_speed_yet, 5);
  go(closed, closed, 0.85, 0.85, 120);
  EXPECT_LT(rms_velocity(simulator.state()), calm);
  const double lifted = simulator.state().positions(held, 2) - before;
  EXPECT_EQ(crossings, 0);

  const auto saved = simulator.save();
  go(closed, closed, 0.85, 0.85, 5);
  const Points expected = simulator.state().positions;
  simulator.restore(*saved);
  go(closed, closed, 0.85, 0.85, 5);
  EXPECT_TRUE(simulator.state().positions == expected) << "pinched or not, to the same bits";
  return lifted;
}

class Fold : public ::testing::TestWithParam<double> {};

TEST_P(Fold, StaysCalmInFingersThatLeaveItLessThanItsThickness) {
  EXPECT_NEAR(lift_fold(GetParam()), 0.15, 5e-3);
}

INSTANTIATE_TEST_SUITE_P(Rooms, Fold, ::testing::Values(0.008, 0.004, -0.002, -0.006));

/// A thumb that presses a cloth onto a table, 2 mm deep, and then moves 0.2 m.
class Thumb : public ::testing::TestWithParam<double> {};

TEST_P(Thumb, DragsTheClothByTheShareOfItsFriction) {
  const double of_table = 0.5, of_thumb = GetParam();
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = side;
  scene.cloth.origin = Vector3(0, 0, surface_offset);
  scene.cloth.material.density = 1;
  scene.simulation.frames_per_second = 60;
  const auto at = [](double x, double z) {
    return Pose{Vector3(x, 0.5, z + 0.05), Eigen::Quaterniond::Identity()};
  };
  scene.colliders = {{"table", Plane{}, {}, of_table, ""},
                     {"thumb", Cuboid{{0.1, 0.1, 0.1}}, at(0.5, 0.2), of_thumb, ""}};
  scene.colliders[0].pose.orientation.setIdentity();
  Simulator simulator(scene);
  double max_speed_yet = 0;
  const auto go = [&](double from_x, double to_x, double from_z, double to_z, int frames) {
    for (int frame = 1; frame <= frames; ++frame) {
      const double share = static_cast<double>(frame) / frames;
      simulator.move_collider(
          1, at(from_x + share * (to_x - from_x), from_z + share * (to_z - from_z)));
      simulator.step();
      max_speed_yet = std::max(max_speed_yet, max_speed(simulator.state()));
    }
  };
  constexpr int centre = 12 * side + 12;
  const auto point = [&] { return row(simulator.state().positions, centre); };
  go(0.5, 0.5, 0.2, -0.002, 60);
  EXPECT_NEAR(point().z(), -0.001, 2e-4) << "midway";
  const double start = point().x();
  // While the point is below it.
  go(0.5, 0.52, -0.002, -0.002, 12);
  EXPECT_NEAR(point().x() - start, 0.02 * of_thumb / (of_table + of_thumb), 1e-3);
  go(0.52, 0.7, -0.002, -0.002, 60);
  go(0.7, 0.7, -0.002, -0.002, 60);
  EXPECT_LT(max_speed_yet, 5);
  EXPECT_LT(rms_velocity(simulator.state()), 0.01);
}

INSTANTIATE_TEST_SUITE_P(Frictions, Thumb, ::testing::Values(0.1, 0.5, 2.0));

}  // namespace
}  // namespace clothsim::pinch_test
