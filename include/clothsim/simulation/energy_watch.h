#pragma once

#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"
#include "clothsim/shapes/moving_collider.h"

namespace clothsim {

/// Judges after each frame whether the cloth may have the energy it has. A method that blows up
/// multiplies its energy within a frame, or little by little, long before numbers overflow.
class EnergyWatch {
 public:
  /// Counts anew from the next frame on: after a change that no work explains.
  void restart() { begun_ = false; }

  /// What it has counted. `read` throws InvalidValue for what was not written.
  void write(MemoryWriter&) const;
  void read(MemoryReader&);

  /// Whether a frame of `dt` [s] from `before` to `after` may have gained the energy it did: no
  /// more than moving pins and colliders can have put in as work, besides a margin for what is
  /// small; and whether all frames since the last restart() may have, by a far wider margin.
  ///
  /// Both states hold the velocities that pins have within the frame, and `colliders` their motion.
  /// `push_out_speed`: speed at which these push out what is in them [m/s]; where it is not 0,
  /// springs are stretched by that, the frame is judged by the wide margin alone, and it counts
  /// anew. `wind`: speed of air that blows on it [m/s]. `external_work`: work of forces from
  /// outside, and of holders on points that slip [J]. False for energies that are not finite.
  bool accepts(const Cloth&, const Vector3& gravity, double dt, const State& before,
               const State& after, const std::vector<MovingCollider>& colliders,
               double push_out_speed = 0, double wind = 0, double external_work = 0);

 private:
  bool begun_ = false;
  double given_ = 0;      // kinetic and elastic energy at the start, and all work since [J]
  double potential_ = 0;  // in gravity, at the start [J]
};

}  // namespace clothsim
