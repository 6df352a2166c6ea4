#include "clothsim/run/pose_trajectory.h"

#include <cassert>
#include <cmath>
#include <limits>

namespace clothsim {
namespace {

/// Below this angle [rad], the first terms of the series of the Jacobians' factors are more
/// accurate than the closed form, which loses digits to cancellation: the fourth root of the
/// rounding of doubles.
const double small_angle = std::sqrt(std::sqrt(std::numeric_limits<double>::epsilon()));

Vector3 rotation_vector(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to) {
  const Eigen::AngleAxisd turn(to * from.conjugate());  // at most pi
  return turn.angle() * turn.axis();
}

// The angular velocity of a frame whose rotation vector is r is J(r) r', with SO(3)'s left
// Jacobian. Chirikjian, Stochastic Models, Information Theory, and Lie Groups 2, 10.86.

Vector3 angular_velocity(const Vector3& r, const Vector3& rate) {
  const double angle = r.norm();
  const bool is_small = angle < small_angle;
  const double square = angle * angle;
  const double once = is_small ? 0.5 : (1 - std::cos(angle)) / square;
  const double twice = is_small ? 1.0 / 6 : (angle - std::sin(angle)) / (square * angle);
  return rate + once * r.cross(rate) + twice * r.cross(r.cross(rate));
}

Vector3 rotation_rate(const Vector3& r, const Vector3& velocity) {
  const double half = r.norm() / 2;
  const bool is_small = half < small_angle;
  const double twice = is_small ? 1.0 / 12 : (1 - half / std::tan(half)) / (4 * half * half);
  return velocity - 0.5 * r.cross(velocity) + twice * r.cross(r.cross(velocity));
}

}  // namespace

Vector3 PoseTrajectory::Cubic::at(double s) const {
  return s * displacement + s * (1 - s) * ((1 - s) * first - s * last);
}

Vector3 PoseTrajectory::Cubic::slope(double s) const {
  return displacement + (1 - s) * (1 - 3 * s) * first + s * (3 * s - 2) * last;
}

PoseTrajectory::PoseTrajectory(const Pose& start, const Twist& start_twist, const Pose& end,
                               const std::optional<Twist>& end_twist, double duration)
    : start_(start), end_(end), duration_(duration) {
  assert(duration > 0);
  position_.displacement = end.position - start.position;
  turn_.displacement = rotation_vector(start.orientation, end.orientation);
  if (!end_twist) return;
  position_.first = duration * start_twist.linear - position_.displacement;
  position_.last = duration * end_twist->linear - position_.displacement;
  turn_.first = duration * start_twist.angular - turn_.displacement;
  turn_.last =
      duration * rotation_rate(turn_.displacement, end_twist->angular) - turn_.displacement;
}

Pose PoseTrajectory::pose_at(double share) const {
  if (share >= 1) return end_;
  return {start_.position + position_.at(share), turned(start_.orientation, turn_.at(share))};
}

Twist PoseTrajectory::twist_at(double share) const {
  return {position_.slope(share) / duration_,
          angular_velocity(turn_.at(share), turn_.slope(share) / duration_)};
}

}  // namespace clothsim
