#pragma once

#include <Eigen/Geometry>

#include "clothsim/shapes/collider.h"

namespace clothsim {

/// A collider that moves from one pose to the next, in a straight line with constant angular
/// velocity.
class MovingCollider {
 public:
  explicit MovingCollider(const ColliderSpec&);

  /// Puts it at `pose`, at rest.
  void place(const Pose& pose);

  /// Sets velocities that bring it to `target` in `duration` [s].
  void set_target(const Pose& target, double duration);

  /// Moves it on by h [s].
  void advance(double h);

  /// Begins a step of a rigid body.
  void begin_step() {
    previous_ = pose_;
    last_turn_.setZero();
  }

  /// Sets the pose of a rigid body at the step's end, and its velocities there.
  void move_to(const Pose& pose, const Vector3& velocity, const Vector3& angular_velocity);

  /// Ends the motion exactly at the target pose.
  void snap_to_target();

  /// A disabled collider moves on without contact.
  void enable(bool enabled) { enabled_ = enabled; }
  bool enabled() const { return enabled_; }

  const Shape& shape() const { return shape_; }
  double friction() const { return friction_; }
  void set_friction(double friction) { friction_ = friction; }
  const Pose& pose() const { return pose_; }
  const Pose& previous() const { return previous_; }  // before the last advance()
  const Pose& target() const { return target_; }      // of the last set_target()

  /// Where it was at a share from 0 to 1 of the last advance().
  Pose pose_at(double share) const;

  /// Angle that it turned by in the last advance() [rad].
  double last_turn() const { return last_turn_.norm(); }

  const Vector3& velocity() const { return velocity_; }                  // [m/s]
  const Vector3& angular_velocity() const { return angular_velocity_; }  // [rad/s], world

  /// Velocity of the solid at `point` in the world [m/s].
  Vector3 velocity_at(const Vector3& point) const;

  /// Where the solid's material point that was at `point` before the last advance() is now, in the
  /// world [m].
  Vector3 carried(const Vector3& point) const;

  /// velocity_at `points`, N x 3 both.
  Points velocities_at(const Points& points) const;

  /// False where no point in `box` of the world can have been within `margin` [m] of the solid
  /// during the last advance(), or where the collider is disabled.
  bool reaches(const Eigen::AlignedBox3d& box, double margin) const;

  /// Fastest speed within `box` of the world [m/s] of the solid, continued through the whole box.
  double max_speed_in(const Eigen::AlignedBox3d& box) const;

 private:
  Shape shape_;
  double friction_;
  bool enabled_;
  Pose pose_;
  Pose previous_;
  Pose target_;
  Vector3 velocity_{0, 0, 0};          // [m/s]
  Vector3 angular_velocity_{0, 0, 0};  // [rad/s], world
  Vector3 last_turn_{0, 0, 0};         // of the last advance(), axis times angle [rad], world
};

}  // namespace clothsim
