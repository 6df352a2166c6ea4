#pragma once

#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/model/types.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// Whether the cloth has internal damping of bends.
inline bool has_damped_bends(const Cloth& cloth) {
  return cloth.internal_damping[1] > 0 && cloth.num_bends() > 0;
}

/// Length of bends below which their directions are taken for rounding errors [m]: the errors of
/// BendMotion are those of bends of 1e-9 m where cells are 1 cm and the cloth is 1 m.
inline constexpr double min_bend = 1e-8;

/// The motion of the bends of one piece of cloth: sums over their stencils b of stiffness k with
/// the rates b', or over pairs of points, see PairBand. For a PatchBend, b stands for b - B n.
struct BendMotion {
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();  // sum of k b b^T [N m]
  Vector3 moment = Vector3::Zero();                   // sum of k b x b' [N m/s]
  double stiffness = 0;                               // sum of the pairs' weights [N/m]

  /// The angular velocity omega [rad/s] that minimizes sum k |b' - omega x b|^2. Goes to zero where
  /// bends are shorter than min_bend.
  Vector3 rotation() const;
};

/// The rotation of each piece of cloth, see BendMotion: one of a grid, those of
/// TriangleFabric::pieces of a mesh. `positions`, `rates`: as below.
std::vector<Vector3> bend_rotations(const Cloth&, const Points& positions, const Points& rates,
                                    const Workers& = {});

/// Writes to `relative` the `rates` of points (velocities [m/s], or displacements [m]) less those
/// of a rotation of each piece of cloth, see BendMotion. All N x 3.
///
/// Damping of bends by relative rates has no torque, since the torque is the minimum's derivative
/// by omega, and does not resist rotation of a piece. Mueller et al. 2007, "Position based
/// dynamics", section 3.5, leave out rotation in the same way, weighted by masses.
void remove_rotation(const Cloth&, const Points& positions, const Points& rates, Points& relative,
                     const Workers& = {});

}  // namespace clothsim
