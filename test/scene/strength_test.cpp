// A robot's ordinary mistakes: commands to hands that cannot be met. Holders give way, lag and come
// back; nothing is flung, crosses or stays stretched.

#include "clothsim/dynamics/stretch.h"
#include "clothsim/geometry/intersections.h"
#include "clothsim/run/report.h"
#include "hanging.h"
#include "verification/testing.h"

namespace clothsim::strength_test {
namespace {

using namespace test;

constexpr double width = 0.4;  // [m]
constexpr int side = 25;

/// A towel or a shirt of 0.4 m with self contact, level, 0.5 m above the ground.
Scene fabric_scene(const std::string& fabric, const std::string& colliders) {
  const std::string size = "width: 0.4, height: 0.4, columns: 25, rows: 25, origin: [0, 0, 0.5]";
  return read_scene(YAML::Load("{cloth: {fabric: " + fabric + ", self_collision: surface, " + size +
                               "}, colliders: [" + colliders + "]}"));
}

Pose at(const Vector3& position) { return {position, Eigen::Quaterniond::Identity()}; }

std::vector<int> first_row() {
  std::vector<int> points(side);
  for (int i = 0; i < side; ++i) points[static_cast<std::size_t>(i)] = i;
  return points;
}

/// A hand that moves in a straight line, with the checks of each frame.
struct Hand {
  Simulator& simulator;
  Vector3 position;

  void move_to(const Vector3& target, double seconds) {
    const Vector3 start = position;
    const int frames = static_cast<int>(std::lround(seconds * 90));
    for (int frame = 1; frame <= frames; ++frame) {
      position = start + (target - start) * frame / frames;
      simulator.move_grip("hand", at(position));
      simulator.step();
      check(frame);
    }
  }
  void wait(double seconds) { move_to(position, seconds); }

  void check(int frame) const {
    ASSERT_EQ(count_intersections(simulator.cloth(), simulator.state().positions), 0) << frame;
    for (const HolderReport& holder : simulator.holders()) {
      // A holder still sticks in the substep that detects its overload.
      ASSERT_LE(holder.force, 1.01 * holder.strength) << holder.name << frame;
    }
  }
};

/// A held edge is moved onto the ground, or `depth` [m] below it, waits there and comes back.
/// Returns the largest stretch where it waits.
double press_on_ground(double depth) {
  Simulator simulator(fabric_scene("cotton_towel", "{name: ground, shape: plane, friction: 0.5}"));
  Hand hand{simulator, {width / 2, 0, 0.5}};
  simulator.attach("hand", at(hand.position), first_row());
  run(simulator, 0.5);
  hand.move_to({width / 2, 0, -depth}, 2);
  hand.wait(3);
  const double stretch = worst_stretch(simulator.cloth(), simulator.state().positions);
  EXPECT_LT(rms_velocity(simulator.state()), 0.01);
  EXPECT_LT(deepest_penetration(simulator), 1e-3);
  EXPECT_GT(simulator.holders()[0].lag, depth);

  hand.move_to({width / 2, 0, 0.3}, 1);
  hand.wait(1);
  EXPECT_EQ(simulator.holders()[0].lag, 0) << "it has come back";
  return stretch;
}

TEST(EdgeOnGround, LagsAndIsStill) {
  // Friction holds a crumple that the edge leaves, in two of seven depths with a diagonal of a cell
  // stretched by 0.2 to 0.35: a median of three.
  std::vector<double> stretches;
  for (const double depth : {0.0, 0.005, 0.006}) {
    SCOPED_TRACE(depth);
    stretches.push_back(press_on_ground(depth));
  }
  std::sort(stretches.begin(), stretches.end());
  EXPECT_LT(stretches[1], 0.1);
  EXPECT_LT(stretches[2], 0.4);
}

TEST(Strength, AnEdgeThatIsDrivenIntoABoxStopsThere) {
  Simulator simulator(
      fabric_scene("cotton_towel",
                   "{name: box, shape: box, center: [0.2, 0, 0.2], size: [0.6, 0.3, 0.3], "
                   "friction: 0.4}"));
  Hand hand{simulator, {width / 2, 0, 0.5}};
  simulator.attach("hand", at(hand.position), first_row());
  hand.move_to({width / 2, 0, 0.25}, 1);
  hand.wait(2);
  EXPECT_LT(worst_stretch(simulator.cloth(), simulator.state().positions), 0.1);
  EXPECT_LT(deepest_penetration(simulator), 1e-3);
  EXPECT_NEAR(simulator.holders()[0].lag, 0.1, 3e-3);
  EXPECT_LT(rms_velocity(simulator.state()), 0.02);
}

TEST(Strength, ACornerThatIsPulledThroughAPlateStopsThere) {
  Simulator simulator(
      fabric_scene("cotton_shirting",
                   "{name: plate, shape: box, center: [0, 0, 0.3], size: [1, 1, 0.004], friction: "
                   "0.4}"));
  Hand hand{simulator, {0, 0, 0.5}};
  simulator.attach("hand", at(hand.position), {0});
  hand.move_to({0, 0, 0.1}, 1);
  EXPECT_LT(max_speed(simulator.state()), 4);
  hand.wait(2);
  EXPECT_GT(simulator.state().positions(0, 2), 0.302);
  EXPECT_LT(worst_stretch(simulator.cloth(), simulator.state().positions), 0.1);
  EXPECT_LT(rms_velocity(simulator.state()), 0.01);
}

TEST(Strength, AHandThatPullsAHangingClothStretchesItNoFurtherThanItsLimit) {
  Simulator simulator(hanging(30));
  run(simulator, 4);
  const Vector3 start = row(simulator.state().positions, 285);
  Hand hand{simulator, start};
  const std::vector<int> held = simulator.free_points_near(start, 0.05);
  simulator.attach("hand", at(start), held);
  double worst = 0;
  for (int part = 0; part < 90; ++part) {
    hand.move_to(start + (part + 1) / 90.0 * Vector3(0.4, -0.2, 0.1), 1.0 / 90);
    worst = std::max(worst, worst_stretch(simulator.cloth(), simulator.state().positions));
  }
  hand.wait(1);
  simulator.detach(held);
  EXPECT_LT(worst, 0.12);
  run(simulator, 2);
  EXPECT_LT(worst_stretch(simulator.cloth(), simulator.state().positions), 0.105);
  for (const HolderReport& pin : simulator.holders()) EXPECT_EQ(pin.lag, 0) << pin.name;
}

TEST(Strength, FingersThatCloseOnHeldPointsFlingNothing) {
  Scene scene = fabric_scene("cotton_towel",
                             "{name: ground, shape: plane, friction: 0.5}, {name: l, shape: box, "
                             "center: [0, 0, 0], size: [0.02, 0.01, 0.04], frame: l, friction: "
                             "0.6}, {name: r, shape: box, center: [0, 0, 0], size: [0.02, 0.01, "
                             "0.04], frame: r, friction: 0.6}");
  scene.cloth.origin = {-width / 2, -width / 2, 0.002};
  Simulator simulator(scene);
  const Vector3 corner(width / 2, width / 2, 0.002), up = corner + Vector3(0, 0, 0.1);
  const auto fingers = [&](const Vector3& middle, double apart) {
    simulator.move_collider(1, at(middle - Vector3(0, apart, 0)));
    simulator.move_collider(2, at(middle + Vector3(0, apart, 0)));
  };
  for (const int i : {1, 2}) {
    simulator.place_collider(i, at(corner + Vector3(0, i == 1 ? -0.1 : 0.1, 0.3)));
  }
  run(simulator, 0.3);
  Hand hand{simulator, corner};
  simulator.attach("hand", at(corner), simulator.free_points_near(corner, 0.02));
  for (int frame = 1; frame <= 90; ++frame) {
    const double share = frame / 90.0;
    fingers(corner + Vector3(0, 0, 0.3) + share * (up - corner - Vector3(0, 0, 0.3)),
            0.1 - 0.05 * share);
    hand.move_to(corner + share * (up - corner), 1.0 / 90);
  }
  double max_point_speed = 0;
  for (int frame = 1; frame <= 45; ++frame) {
    fingers(up, 0.05 - 0.044 * frame / 45);
    hand.wait(1.0 / 90);
    max_point_speed = std::max(max_point_speed, max_speed(simulator.state()));
  }
  EXPECT_LT(max_point_speed, 4) << "a fold that snaps over a corner of a finger, for a frame";
}

}  // namespace
}  // namespace clothsim::strength_test
