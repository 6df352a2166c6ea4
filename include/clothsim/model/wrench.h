#pragma once

#include "clothsim/model/types.h"

namespace clothsim {

/// Force [N] and torque [N m] about an origin, in the world.
struct Wrench {
  Vector3 force{0, 0, 0};
  Vector3 torque{0, 0, 0};

  /// Adds a force [N] that acts at `arm` [m] from the origin.
  void add(const Vector3& arm, const Vector3& more) {
    force += more;
    torque += arm.cross(more);
  }
};

/// Load of a cloth on a collider.
struct ContactLoad {
  Wrench wrench;
  double normal_force = 0;  // sum of the magnitudes of all normal forces [N]
};

}  // namespace clothsim
