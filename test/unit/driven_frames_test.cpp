#include "clothsim/run/driven_frames.h"

#include <gtest/gtest.h>

#include <limits>

#include "state_testing.h"

namespace clothsim::driven_frames_test {
namespace {

using test::busy;
using test::expect_same;

/// A ball, a box and a pin that follow frames.
Scene followers() {
  Scene scene = busy("auto");
  scene.colliders[0].frame = "ball";
  ColliderSpec box;
  box.name = "box";
  box.shape = Cuboid{};
  box.pose.position = Vector3(0, 0, -1);
  box.frame = "arm";
  scene.colliders.push_back(box);
  scene.cloth.pinned = {{0, 0, "hand"}, {9, 0, "arm"}};
  return scene;
}

FrameTarget at(const Vector3& position, double angle = 0) {
  return {{position, Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vector3::UnitZ()))}};
}

void run(int frames, DrivenFrames& driven, Simulator& simulator) {
  for (int k = 0; k < frames; ++k) {
    driven.move(simulator);
    simulator.step();
  }
}

TEST(DrivenFrames, FiveCentimetresInNineFramesAreNineEqualMoves) {
  Simulator simulator(followers());
  DrivenFrames driven;
  const Vector3 start = simulator.collider_pose(0).position;
  driven.set_targets({{"ball", at(start + Vector3(0, 0, 0.05))}}, 9, simulator);
  for (int k = 1; k <= 9; ++k) {
    run(1, driven, simulator);
    EXPECT_NEAR(simulator.collider_pose(0).position.z() - start.z(), 0.05 * k / 9, 1e-15);
  }
  EXPECT_EQ(simulator.collider_pose(0).position, start + Vector3(0, 0, 0.05));
  run(3, driven, simulator);  // and there it stays
  EXPECT_EQ(simulator.collider_pose(0).position, start + Vector3(0, 0, 0.05));
}

TEST(DrivenFrames, GiveTheBitsOfMovesByHand) {
  Simulator simulator(followers()), by_hand(followers());
  DrivenFrames driven;
  const Vector3 start = simulator.collider_pose(0).position;
  driven.set_targets({{"ball", at(start + Vector3(0, 0, 0.25))}}, 4, simulator);
  run(4, driven, simulator);
  for (int k = 1; k <= 4; ++k) {
    by_hand.move_collider(
        0, {start + Vector3(0, 0, 0.25) * (k / 4.0), simulator.collider_pose(0).orientation});
    by_hand.step();
  }
  expect_same(simulator.state(), by_hand.state());
}

TEST(DrivenFrames, PinsKeepTheirOffsetAndTurnWithTheFrame) {
  Simulator simulator(followers());
  DrivenFrames driven;
  FrameTarget target = at({0, 0, 1.0}, M_PI / 2);
  target.start = Pose{{0, 0, 1}, Eigen::Quaterniond::Identity()};  // the pin is at x = 1
  driven.set_targets({{"arm", target}}, 30, simulator);
  EXPECT_EQ(simulator.collider_pose(1).position, Vector3(0, 0, 1)) << "the box is put at the start";
  run(30, driven, simulator);
  const Vector3 pin = simulator.state().positions.row(9).transpose();
  EXPECT_LT((pin - Vector3(0, 1, 1)).norm(), 1e-12);
  EXPECT_EQ(driven.pose("arm")->position, Vector3(0, 0, 1));
  EXPECT_EQ(driven.pose("nobody"), nullptr);
}

TEST(DrivenFrames, CarryWhatIsAttached) {
  Simulator simulator(followers());
  DrivenFrames driven;
  const Vector3 corner = simulator.state().positions.row(99).transpose();
  simulator.attach("gripper", {corner, Eigen::Quaterniond::Identity()}, {99});
  driven.set_targets({{"gripper", at(corner + Vector3(0, 0, 0.1))}}, 10, simulator);
  run(10, driven, simulator);
  const Vector3 held = simulator.state().positions.row(99).transpose();
  EXPECT_LT((held - corner - Vector3(0, 0, 0.1)).norm(), 1e-12);
}

TEST(DrivenFrames, VelocityIsContinuousFromCallToCall) {
  FrameMotion motion({{0, 0, 0}, Eigen::Quaterniond::Identity()});
  const double dt = 0.01;
  FrameTarget target = at({0.3, 0, 0});
  target.twist = Twist{{1, 0.5, 0}, {0, 0, 2}};
  motion.set_target(target, 20, dt);
  for (int k = 0; k < 20; ++k) motion.advance();
  EXPECT_LT((motion.twist().linear - target.twist->linear).norm(), 1e-12);
  EXPECT_LT((motion.twist().angular - target.twist->angular).norm(), 1e-12);

  // The next call continues from there: its first moves equal the last ones.
  FrameTarget rest = at({0.5, 0.2, 0}, 0.4);
  rest.twist = Twist{};
  motion.set_target(rest, 2000, dt / 100);
  const Vector3 before = motion.pose().position;
  const Vector3 move = motion.advance().position - before;
  EXPECT_LT((move / (dt / 100) - target.twist->linear).norm(), 0.02);
  for (int k = 1; k < 2000; ++k) motion.advance();
  EXPECT_LT(motion.twist().linear.norm() + motion.twist().angular.norm(), 1e-12);
}

TEST(DrivenFrames, ACopyGoesOnToTheSameBits) {
  Simulator simulator(followers());
  DrivenFrames driven;
  FrameTarget target = at(simulator.collider_pose(0).position + Vector3(0.1, 0, 0.1));
  target.twist = Twist{{0.1, 0, 0}, {0, 0, 1}};
  driven.set_targets({{"ball", target}, {"hand", at({0, 0, 1.1})}}, 20, simulator);
  run(7, driven, simulator);
  const auto saved = simulator.save();
  const DrivenFrames copy = driven;
  run(20, driven, simulator);
  const State once = simulator.state();

  simulator.restore(*saved);
  driven = copy;
  run(20, driven, simulator);
  expect_same(once, simulator.state());
}

TEST(DrivenFrames, APinThatIsPlacedStaysThere) {
  Simulator simulator(followers());
  const Vector3 place(0.01, 0.02, 1.03);
  simulator.place_pin(0, place);
  EXPECT_EQ(simulator.state().positions.row(0).transpose(), place);
  simulator.step();
  EXPECT_EQ(simulator.state().positions.row(0).transpose(), place);
  EXPECT_TRUE(simulator.state().velocities.row(0).isZero(0));
  EXPECT_THROW(simulator.place_pin(0, Vector3(0, 1e13, 0)), InvalidValue);
  EXPECT_THROW(simulator.place_pin(2, place), std::out_of_range);
}

TEST(DrivenFrames, RefuseWhatIsNoTargetAndChangeNothing) {
  Simulator simulator(followers());
  DrivenFrames driven;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  FrameTarget spinning = at({0, 0, 0}), crooked = at({0, 0, 0}), lost = at({0, 0, 0});
  spinning.twist = Twist{{0, 0, 0}, {0, nan, 0}};
  crooked.pose.orientation.coeffs() *= 2;
  lost.start = Pose{{0, 1e13, 0}, Eigen::Quaterniond::Identity()};
  const auto message = [&](const FrameTarget& target, int frames = 1) -> std::string {
    try {
      driven.set_targets({{"arm", at({0, 0, 3})}, {"hand", target}}, frames, simulator);
    } catch (const InvalidValue& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(message(at({0, nan, 0})).find("hand.position.1: got nan"), std::string::npos);
  EXPECT_NE(message(spinning).find("hand.twist.angular.1"), std::string::npos);
  EXPECT_NE(message(crooked).find("hand.orientation"), std::string::npos);
  EXPECT_NE(message(lost).find("hand.start.position.1"), std::string::npos);
  EXPECT_NE(message(at({0, 0, 0}), 0).find("frames: got 0"), std::string::npos);
  EXPECT_EQ(driven.pose("arm"), nullptr);
}

TEST(DrivenFrames, NamesWhatIsFollowed) {
  Simulator simulator(followers());
  simulator.attach("gripper", {}, {55});
  EXPECT_EQ(followed_frames(simulator),
            (std::vector<std::string>{"arm", "ball", "gripper", "hand"}));
}

}  // namespace
}  // namespace clothsim::driven_frames_test
