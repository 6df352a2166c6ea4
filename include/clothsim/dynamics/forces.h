#pragma once

#include "clothsim/model/cloth.h"
#include "clothsim/model/types.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// Loads on a cloth in a step, apart from drag, which is a property of the cloth.
struct Loads {
  Vector3 gravity{0, 0, -9.8};  // [m/s^2]
  bool acts_alone = false;      // nothing holds the cloth: methods let it fall exactly
  /// Changes of the velocities of free points by impulses in a step [m/s], N x 3; null: none. For
  /// methods that begin with free_step().
  const Points* impulses = nullptr;
};

/// Writes gravity and the forces of springs and bends [N] at `positions` to `forces`, both N x 3.
/// Hooke's law: k (l - L0) (x_b - x_a) / l on point a, the opposite on b. A spring of zero length
/// has no direction and no force. Bends: minus the gradient of their energy, see BendRun.
///
/// `velocities` [m/s], N x 3: adds internal damping, k tau_0 times the rate of a spring's length,
/// and the force of bends at tau_1 times the velocities less a rotation, see remove_rotation().
/// Null: no damping.
void compute_forces(const Cloth&, const Loads&, const Points& positions, Points& forces,
                    const Workers& = {}, const Points* velocities = nullptr);

}  // namespace clothsim
