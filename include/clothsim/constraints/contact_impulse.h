#pragma once

#include <algorithm>
#include <cmath>

#include "clothsim/model/memory.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// Impulse of a surface on the cloth [N s]; for contacts of single points divided by their mass
/// [m/s].
struct ContactImpulse {
  Vector3 normal{0, 0, 1};            // into free space
  Vector3 surface_velocity{0, 0, 0};  // [m/s]
  double target_velocity = 0;  // least normal velocity allowed; > 0: away from the surface [m/s]
  double friction = 0;
  double max_normal_impulse = infinity;      // in total
  double max_separating_impulse = infinity;  // where it separates an overlap
  double normal_impulse = 0;                 // along the normal, >= 0
  Vector3 friction_impulse{0, 0, 0};         // against sliding, at most friction * normal_impulse

  /// Updates the impulse for the relative motion of a contact with `velocity` [m/s] and effective
  /// `mass`: an impulse p changes that velocity by p / mass. Returns the change of the impulse.
  Vector3 update(const Vector3& velocity, double mass) { return update(velocity, mass, mass); }

  /// The same with another effective mass, `tangential_mass`, for impulses along the surface.
  Vector3 update(const Vector3& velocity, double mass, double tangential_mass) {
    const Vector3 v = velocity - surface_velocity;

    // The normal velocity may not fall below target_velocity.
    const double rate = normal.dot(v);
    double new_normal_impulse = normal_impulse + mass * (target_velocity - rate);
    if (target_velocity > 0) {
      new_normal_impulse = std::min(new_normal_impulse,
                                    std::max(normal_impulse - mass * rate, max_separating_impulse));
    }
    new_normal_impulse = std::clamp(new_normal_impulse, 0.0, max_normal_impulse);

    // Projection onto Coulomb's cone.
    Vector3 new_friction_impulse = friction_impulse - tangential_mass * (v - rate * normal);
    const double max_friction = friction * new_normal_impulse;
    const double length2 = new_friction_impulse.squaredNorm();
    if (length2 > max_friction * max_friction) {
      new_friction_impulse *= max_friction / std::sqrt(length2);
    }

    const Vector3 change =
        (new_normal_impulse - normal_impulse) * normal + new_friction_impulse - friction_impulse;
    normal_impulse = new_normal_impulse;
    friction_impulse = new_friction_impulse;
    return change;
  }

  /// Scales the impulse, and makes its friction tangential to the present normal.
  void warm_start(double scale) {
    normal_impulse *= scale;
    friction_impulse *= scale;
    friction_impulse -= normal.dot(friction_impulse) * normal;
  }

  /// Takes the impulse of the last step, for warm_start().
  void keep(const ContactImpulse& last) {
    normal_impulse = last.normal_impulse;
    friction_impulse = last.friction_impulse;
  }

  /// The same contact with an impulse that many times as large.
  ContactImpulse scaled(double factor) const {
    ContactImpulse result = *this;
    result.normal_impulse *= factor;
    result.friction_impulse *= factor;
    return result;
  }

  Vector3 total() const { return normal_impulse * normal + friction_impulse; }

  /// Lowers the bound on the normal impulse, and scales the present impulse down to it.
  void limit_normal_impulse(double strongest) {
    max_normal_impulse = std::min(max_normal_impulse, strongest);
    if (normal_impulse > max_normal_impulse) warm_start(max_normal_impulse / normal_impulse);
  }

  /// Ends the contact: no impulse from now on.
  void deactivate() {
    target_velocity = -infinity;
    normal_impulse = friction = 0;
    friction_impulse.setZero();
  }

  /// The state that the next step starts with: the impulse, without the data of the surface.
  void write(MemoryWriter& memory) const {
    memory.add(normal_impulse);
    memory.add(friction_impulse);
  }
  void read(MemoryReader& memory) {
    normal_impulse = std::max(0.0, memory.number());
    friction_impulse = memory.vector();
  }
};

}  // namespace clothsim
