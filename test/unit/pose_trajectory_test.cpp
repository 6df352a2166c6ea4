#include "clothsim/run/pose_trajectory.h"

#include <gtest/gtest.h>

#include <cmath>

namespace clothsim::pose_trajectory_test {
namespace {

const Vector3 axis = Vector3(1, -2, 0.5).normalized();

Pose pose(const Vector3& position, double angle, const Vector3& about = axis) {
  return {position, Eigen::Quaterniond(Eigen::AngleAxisd(angle, about))};
}

/// Velocities by central differences of the poses.
Twist difference(const PoseTrajectory& trajectory, double share, double duration) {
  const double h = 1e-5;
  const Pose a = trajectory.pose_at(share - h), b = trajectory.pose_at(share + h);
  const Eigen::AngleAxisd turn(b.orientation * a.orientation.conjugate());
  const double time = 2 * h * duration;
  return {(b.position - a.position) / time, turn.angle() * turn.axis() / time};
}

TEST(PoseTrajectory, WithoutATwistMovesAreEqualAndTurnsAreSlerp) {
  const Pose start = pose({1, 2, 3}, 0.3), end = pose({1.05, 2, 2}, 2.9, Vector3::UnitX());
  const PoseTrajectory trajectory(start, {{9, 9, 9}, {9, 9, 9}}, end, {}, 0.1);
  for (int k = 0; k <= 9; ++k) {
    const double s = k / 9.0;
    const Pose at = trajectory.pose_at(s);
    EXPECT_LT((at.position - (start.position + s * (end.position - start.position))).norm(), 1e-14);
    EXPECT_LT(at.orientation.angularDistance(start.orientation.slerp(s, end.orientation)), 1e-7);
    EXPECT_LT((trajectory.twist_at(s).linear - Vector3(0.5, 0, -10)).norm(), 1e-12);
  }
  EXPECT_EQ(trajectory.pose_at(1).position, end.position);
  EXPECT_EQ(trajectory.pose_at(1).orientation.coeffs(), end.orientation.coeffs());
}

TEST(PoseTrajectory, GoesTheShortWayRound) {
  const PoseTrajectory trajectory(pose({0, 0, 0}, 3), {}, pose({0, 0, 0}, -3), {}, 1);
  EXPECT_LT(trajectory.pose_at(0.5).orientation.angularDistance(pose({0, 0, 0}, M_PI).orientation),
            1e-7);
}

TEST(PoseTrajectory, BeginsAndEndsWithTheTwists) {
  const Twist first{{0.3, -1, 2}, {1, 0.2, -0.4}}, last{{-2, 0, 0.1}, {-0.3, 2, 0.7}};
  for (const double angle : {0.0, 1e-6, 1.0, 3.1}) {
    const double duration = 0.7;
    const PoseTrajectory trajectory(pose({1, 0, 0}, 0.4), first, pose({0, 1, 0}, 0.4 + angle), last,
                                    duration);
    EXPECT_LT((trajectory.twist_at(0).linear - first.linear).norm(), 1e-12);
    EXPECT_LT((trajectory.twist_at(0).angular - first.angular).norm(), 1e-9);
    EXPECT_LT((trajectory.twist_at(1).linear - last.linear).norm(), 1e-12);
    EXPECT_LT((trajectory.twist_at(1).angular - last.angular).norm(), 1e-9) << angle;
    EXPECT_LT((trajectory.pose_at(1 - 1e-9).position - trajectory.end().position).norm(), 1e-8);
    EXPECT_LT(
        trajectory.pose_at(1 - 1e-9).orientation.angularDistance(trajectory.end().orientation),
        1e-7);
    for (const double share : {0.1, 0.5, 0.8}) {
      const Twist told = trajectory.twist_at(share),
                  measured = difference(trajectory, share, duration);
      EXPECT_LT((told.linear - measured.linear).norm(), 1e-6);
      EXPECT_LT((told.angular - measured.angular).norm(), 1e-5) << angle << ' ' << share;
    }
  }
}

TEST(PoseTrajectory, IsExactForCubics) {
  const auto position = [](double t) { return Vector3(t * t * t, 2 * t * t - t, 3); };
  const auto velocity = [](double t) { return Vector3(3 * t * t, 4 * t - 1, 0); };
  const PoseTrajectory trajectory(pose(position(1), 0), {velocity(1), {0, 0, 0}},
                                  pose(position(3), 0), Twist{velocity(3), {0, 0, 0}}, 2);
  for (const double t : {1.0, 1.3, 2.0, 2.9})
    EXPECT_LT((trajectory.pose_at((t - 1) / 2).position - position(t)).norm(), 1e-13) << t;
}

/// A rotation that tumbles, with its angular velocity: R = Rz(a) Rx(b), w = a' z + b' Rz(a) x.
TEST(PoseTrajectory, FollowsARotationToFourthOrder) {
  const auto turn = [](double t) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(std::sin(2 * t), Vector3::UnitZ()) *
                              Eigen::AngleAxisd(t * t, Vector3::UnitX()));
  };
  const auto twist = [](double t) {
    const Eigen::AngleAxisd about_z(std::sin(2 * t), Vector3::UnitZ());
    const Vector3 angular =
        2 * std::cos(2 * t) * Vector3::UnitZ() + 2 * t * (about_z * Vector3::UnitX());
    return Twist{{0, 0, 0}, angular};
  };
  const auto error = [&](int trajectories) {
    double worst = 0;
    for (int k = 0; k < trajectories; ++k) {
      const double a = 1.0 * k / trajectories, b = 1.0 * (k + 1) / trajectories;
      const PoseTrajectory trajectory({{0, 0, 0}, turn(a)}, twist(a), {{0, 0, 0}, turn(b)},
                                      twist(b), b - a);
      const Eigen::Quaterniond middle = trajectory.pose_at(0.5).orientation;
      worst = std::max(worst, (middle * turn((a + b) / 2).conjugate()).vec().norm());
    }
    return worst;
  };
  const double order = std::log2(error(8) / error(16));
  EXPECT_GT(order, 3.7);
  EXPECT_LT(order, 4.3);
}

}  // namespace
}  // namespace clothsim::pose_trajectory_test
