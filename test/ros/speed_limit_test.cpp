// Motion of points that tf frames hold, after a jump of a frame.

#include <gtest/gtest.h>

#include <cmath>

#include "clothsim/ros/jumps.h"

namespace clothsim_ros::speed_limit_test {
namespace {

using clothsim::Pose;
using clothsim::Vector3;

constexpr double frame = 0.01;  // [s]

TEST(SpeedLimit, LetsSlowPointsArriveToTheLastBit) {
  SpeedLimit limit(10);
  const Vector3 to(0.1, 0.03, -0.7);
  EXPECT_EQ(limit.toward(to + Vector3(0.06, 0, 0.07), to, frame, "hand"), to);
  EXPECT_EQ(limit.toward(to, to, frame, "hand"), to);
  EXPECT_EQ(SpeedLimit(0).toward(to, to, frame, "hand"), to);
}

TEST(SpeedLimit, BoundsAJump) {
  SpeedLimit limit(10);
  const Vector3 to(1000, 0, 0);
  Vector3 at(0, 0, 0);
  for (int i = 1; i <= 20; ++i) {
    at = limit.toward(at, to, frame, "hand");
    EXPECT_NEAR(at.x(), 0.1 * i, 1e-9);
  }
}

TEST(SpeedLimit, BoundsWhatATurnDoesToTheFarthestPoint) {
  SpeedLimit limit(10);
  const double reach = 2;
  Pose at, to;
  to.orientation = Eigen::AngleAxisd(M_PI / 2, Vector3::UnitZ());
  int frames = 0;
  while (at.orientation.angularDistance(to.orientation) > 0 && frames < 100) {
    const Pose next = limit.toward(at, to, reach, frame, "hand");
    const Vector3 farthest(reach, 0, 0);
    EXPECT_LE((next.orientation * farthest - at.orientation * farthest).norm(), 0.1 + 1e-9);
    at = next;
    ++frames;
  }
  EXPECT_EQ(frames, std::ceil(reach * M_PI / 2 / 0.1));
  EXPECT_EQ(at.orientation.coeffs(), to.orientation.coeffs());
}

}  // namespace
}  // namespace clothsim_ros::speed_limit_test
