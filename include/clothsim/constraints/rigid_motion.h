#pragma once

#include "clothsim/model/types.h"
#include "clothsim/model/wrench.h"

namespace clothsim {

/// The matrix whose product with a vector is the vector product of `v` and it.
inline Matrix3 cross_matrix(const Vector3& v) {
  Matrix3 result;
  result << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return result;
}

/// The motion of a collider as contacts change it: that of a rigid body, or of a kinematic
/// collider, whose inverse masses are zero. A joint leaves those along its free motion: u u^T / m
/// for a slider along the unit vector u, u u^T / I for a hinge with the moment of inertia I about
/// its axis u.
struct RigidMotion {
  Vector3 center{0, 0, 0};                // of mass; of a hinge, a point of the axis; in the world
  Vector3 velocity{0, 0, 0};              // of the centre [m/s]
  Vector3 angular_velocity{0, 0, 0};      // in the world [rad/s]
  Matrix3 inv_mass = Matrix3::Zero();     // [1/kg]
  Matrix3 inv_inertia = Matrix3::Zero();  // about the centre, in the world [1 / (kg m^2)]
  double least_inv_mass = 0;              // the smallest in any direction [1/kg]
  bool is_body = false;

  /// Velocity of the solid at a place [m/s].
  Vector3 velocity_at(const Vector3& x) const {
    return velocity + angular_velocity.cross(x - center);
  }

  /// Adds an impulse [N s] at a place.
  void give(const Vector3& impulse, const Vector3& x) {
    velocity += inv_mass * impulse;
    angular_velocity += inv_inertia * (x - center).cross(impulse);
  }

  /// Adds an impulse [N s] with a moment about the centre [N m s].
  void give(const Wrench& impulse) {
    velocity += inv_mass * impulse.force;
    angular_velocity += inv_inertia * impulse.torque;
  }

  /// Velocity change at a place along a unit vector, per impulse along it [1/kg].
  double inv_mass_at(const Vector3& x, const Vector3& direction) const {
    if (!is_body) return 0;
    const Vector3 moment = (x - center).cross(direction);
    return direction.dot(inv_mass * direction) + moment.dot(inv_inertia * moment);
  }

  /// A bound on that across a unit vector: the sum over two directions, less the smallest one.
  double inv_mass_across(const Vector3& x, const Vector3& normal) const {
    if (!is_body) return 0;
    const Vector3 u = normal.unitOrthogonal(), w = normal.cross(u);
    return inv_mass_at(x, u) + inv_mass_at(x, w) - least_inv_mass;
  }
};

}  // namespace clothsim
