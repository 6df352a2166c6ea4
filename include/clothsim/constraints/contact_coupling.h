#pragma once

#include <array>

#include "clothsim/constraints/contact_impulse.h"
#include "clothsim/constraints/rigid_motion.h"

namespace clothsim {

/// A place of the cloth between a rigid body and another collider: a point in contact with both, or
/// a place of a triangle whose corners are in contact with the other collider.
///
/// Light cloth passes the load of a heavy body on to a table in as many passes as the body is
/// heavier. So one more update acts on both contacts at once, with impulses on the cloth that are
/// opposite: the body feels the table as if it touched it, and the impulses of both contacts, which
/// bound friction, have the load in them. The solution stays the same: the update only descends
/// along the sum of some rows.
struct ContactCoupling {
  /// A point of the place.
  struct Corner {
    double weight;        // of its velocity in that of the place
    double mass;          // [kg]
    Vector3 x;            // [m]
    ContactImpulse of_b;  // of the other collider, on 1 kg
    Vector3 velocity;     // [m/s]
  };

  Vector3 x{0, 0, 0};   // [m]
  ContactImpulse of_a;  // of the body, on the cloth [N s]
  std::array<Corner, 3> corners;
  std::size_t count = 0;        // of corners
  double strongest = infinity;  // normal impulse of the body [N s]

  /// Updates the impulses, the velocities of the corners and the motions of both colliders. Returns
  /// the largest change of a relative velocity [m/s].
  double update(RigidMotion& a, RigidMotion& b);

 private:
  double stop_sliding(RigidMotion& a, RigidMotion& b);
  double stop_approach(RigidMotion& a, RigidMotion& b);
  bool release(double less, RigidMotion& a, RigidMotion& b);
  void give(Corner&, const Vector3& of_a, const Vector3& of_b, RigidMotion& a, RigidMotion& b);
};

/// Are these normals opposite, so that an impulse passes straight through the cloth between them?
bool are_opposite(const Vector3& normal_a, const Vector3& normal_b);

}  // namespace clothsim
