#pragma once

#include <optional>
#include <string>

#include "clothsim/model/types.h"
#include "clothsim/shapes/shape.h"

namespace clothsim {

/// Position and orientation of a frame in the world.
struct Pose {
  Vector3 position{0, 0, 0};  // [m]
  Eigen::Quaterniond orientation{1, 0, 0, 0};
};

/// Whether two poses are equal to the last bit.
inline bool same(const Pose& a, const Pose& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs();
}

/// An orientation after a rotation by a vector of axis times angle [rad].
inline Eigen::Quaterniond turned(const Eigen::Quaterniond& orientation, const Vector3& turn) {
  const double angle = turn.norm();
  if (angle == 0) return orientation;
  return (Eigen::AngleAxisd(angle, turn / angle) * orientation).normalized();
}

/// A point of the world in the frame at `pose`.
inline Vector3 to_local(const Pose& pose, const Vector3& point) {
  return pose.orientation.conjugate() * (point - pose.position);
}

/// A point of the frame at `pose` in the world.
inline Vector3 to_world(const Pose& pose, const Vector3& local) {
  return pose.position + pose.orientation * local;
}

/// The pose in the world of a frame at `inner` in a frame at `outer`.
inline Pose operator*(const Pose& outer, const Pose& inner) {
  return {to_world(outer, inner.position), outer.orientation * inner.orientation};
}

/// The pose of a frame in which `pose` of the world is `inner`.
inline Pose frame_of(const Pose& pose, const Pose& inner) {
  const Eigen::Quaterniond turn = pose.orientation * inner.orientation.conjugate();
  return {pose.position - turn * inner.position, turn};
}

/// A joint between a rigid body and the world, with one degree of freedom.
struct Joint {
  enum class Kind { slider, hinge };
  Kind kind = Kind::slider;
  Vector3 axis{0, 0, 1};   // unit, in the world
  Vector3 point{0, 0, 0};  // of the axis of a hinge, in the world [m]
  // Range of the displacement [m], or of the angle [rad], which are 0 at the start:
  double lower = -infinity;
  double upper = infinity;
};

/// The mass and the first motion of a collider that the cloth moves, a rigid body.
struct BodySpec {
  double mass = 1;                        // [kg]
  std::optional<Vector3> center_of_mass;  // in the shape's own frame [m]; empty: even density
  std::optional<Matrix3> inertia;         // about that centre, axes of the frame [kg m^2]; the same
  double damping = 0;                     // share of its velocities lost to air [1/s]
  Vector3 velocity{0, 0, 0};              // of the centre of mass at the start [m/s]
  Vector3 angular_velocity{0, 0, 0};      // the same, in the world [rad/s]
  std::optional<Joint> joint = {};        // empty: it moves freely
};

/// A collider as a scene describes it.
struct ColliderSpec {
  std::string name;
  Shape shape = Sphere{0.2};
  Pose pose;                          // of its frame in the world at the start
  double friction = 0;                // Coulomb's coefficient, static and dynamic
  std::string frame;                  // tf frame that carries the shape; empty: fixed
  bool enabled = true;                // false: no contact
  Pose offset = {};                   // of the shape in its frame
  std::optional<BodySpec> body = {};  // empty: a kinematic collider
  std::string part_of = {};           // name of the body that it is a further shape of; or empty
};

}  // namespace clothsim
