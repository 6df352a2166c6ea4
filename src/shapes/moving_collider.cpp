#include "clothsim/shapes/moving_collider.h"

#include <algorithm>
#include <cmath>

namespace clothsim {

MovingCollider::MovingCollider(const ColliderSpec& spec)
    : shape_(spec.shape), friction_(spec.friction), enabled_(spec.enabled) {
  place(spec.pose * spec.offset);
}

void MovingCollider::place(const Pose& pose) {
  pose_ = previous_ = target_ = pose;
  last_turn_.setZero();
  velocity_.setZero();
  angular_velocity_.setZero();
}

void MovingCollider::set_target(const Pose& target, double duration) {
  target_ = target;
  velocity_ = (target.position - pose_.position) / duration;
  const Eigen::AngleAxisd turn(target.orientation * pose_.orientation.conjugate());  // at most pi
  angular_velocity_ = turn.angle() / duration * turn.axis();
}

void MovingCollider::advance(double h) {
  previous_ = pose_;
  pose_.position += h * velocity_;
  last_turn_ = h * angular_velocity_;
  pose_.orientation = turned(previous_.orientation, last_turn_);
}

void MovingCollider::move_to(const Pose& pose, const Vector3& velocity,
                             const Vector3& angular_velocity) {
  pose_ = target_ = pose;
  const Eigen::AngleAxisd turn(pose.orientation * previous_.orientation.conjugate());
  last_turn_ = turn.angle() * turn.axis();
  velocity_ = velocity;
  angular_velocity_ = angular_velocity;
}

Pose MovingCollider::pose_at(double share) const {
  return {previous_.position + share * (pose_.position - previous_.position),
          turned(previous_.orientation, share * last_turn_)};
}

void MovingCollider::snap_to_target() { place(target_); }

Vector3 MovingCollider::velocity_at(const Vector3& point) const {
  return velocity_ + angular_velocity_.cross(point - pose_.position);
}

Vector3 MovingCollider::carried(const Vector3& point) const {
  const Vector3 displacement = pose_.position - previous_.position;
  const Vector3 arm = point - previous_.position;
  const double angle = last_turn_.norm();
  if (angle == 0) return point + displacement;
  return point + displacement + (Eigen::AngleAxisd(angle, last_turn_ / angle) * arm - arm);
}

Points MovingCollider::velocities_at(const Points& points) const {
  Points velocities = velocity_.transpose().replicate(points.rows(), 1);
  if (angular_velocity_.isZero(0)) return velocities;
  for (int axis = 0; axis < 3; ++axis) {
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    velocities.col(axis).array() +=
        angular_velocity_[next] * (points.col(last).array() - pose_.position[last]) -
        angular_velocity_[last] * (points.col(next).array() - pose_.position[next]);
  }
  return velocities;
}

bool MovingCollider::reaches(const Eigen::AlignedBox3d& box, double margin) const {
  if (!enabled_) return false;
  const auto* plane = std::get_if<Plane>(&shape_);
  if (!plane) {
    const Eigen::AlignedBox3d path = Eigen::AlignedBox3d(previous_.position).extend(pose_.position);
    return std::sqrt(box.squaredExteriorDistance(path)) <= bounding_radius(shape_) + margin;
  }
  // A plane, before and after the step: by the lowest corner of the box.
  double height[2];  // of the box's middle
  double least = infinity;
  for (const int end : {0, 1}) {
    const Pose& pose = end == 0 ? previous_ : pose_;
    const Vector3 normal = pose.orientation * Vector3::UnitZ();
    height[end] = normal.dot(box.center() - pose.position);
    const double spread = normal.cwiseAbs().dot(box.sizes() / 2);
    least = std::min(least, (plane->two_sided ? std::abs(height[end]) : height[end]) - spread);
  }
  const bool has_passed = plane->two_sided && (height[0] < 0) != (height[1] < 0);
  return has_passed || least <= margin;
}

double MovingCollider::max_speed_in(const Eigen::AlignedBox3d& box) const {
  double max_speed = 0;  // at a corner, as velocities are linear in the point
  for (int corner = 0; corner < 8; ++corner) {
    const auto at = static_cast<Eigen::AlignedBox3d::CornerType>(corner);
    max_speed = std::max(max_speed, velocity_at(box.corner(at)).norm());
  }
  return max_speed;
}

}  // namespace clothsim
