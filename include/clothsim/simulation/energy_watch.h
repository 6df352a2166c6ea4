#pragma once

#include <vector>

#include "clothsim/collision/moving_collider.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// Whether a frame of `dt` [s] from `before` to `after` may have gained the energy it did: no more
/// than moving pins and colliders can have put in as work, besides a margin for what is small. A
/// method that blows up multiplies its energy within a frame, long before numbers overflow.
///
/// Both states hold the velocities that pins have within the frame, and `colliders` their motion.
/// False for energies that are not finite.
bool energy_is_plausible(const Cloth&, const Vector3& gravity, double dt, const State& before,
                         const State& after, const std::vector<MovingCollider>& colliders);

}  // namespace clothsim
