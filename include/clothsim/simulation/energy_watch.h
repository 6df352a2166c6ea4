#pragma once

#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"
#include "clothsim/shapes/moving_collider.h"

namespace clothsim {

/// Checks after each frame whether the energy of the cloth is possible. An unstable method
/// multiplies the energy within a frame, or little by little, long before numbers overflow.
class EnergyWatch {
 public:
  /// Restarts the sums of energy and work with the next frame: to be called after a change that no
  /// work explains.
  void restart() { begun_ = false; }

  /// The state of these sums. `read` throws InvalidValue for data that is not from `write`.
  void write(MemoryWriter&) const;
  void read(MemoryReader&);

  /// Whether the energy gained in a frame of `dt` [s] from `before` to `after` is possible: at most
  /// the work of moving pins and colliders, plus a margin for small energies. The same must hold
  /// over all frames since the last restart(), with a far wider margin.
  ///
  /// Both states hold the velocities that pins have within the frame, and `colliders` their motion.
  /// `push_out_speed`: speed of recovery from colliders [m/s]; where it is not 0, recovery
  /// stretches springs, so only the wide margin applies, and the sums restart. `wind`: speed of the
  /// air [m/s]. `external_work`: work of external forces, and of holders on points that slip [J].
  /// False for energies that are not finite.
  bool accepts(const Cloth&, const Vector3& gravity, double dt, const State& before,
               const State& after, const std::vector<MovingCollider>& colliders,
               double push_out_speed = 0, double wind = 0, double external_work = 0);

 private:
  bool begun_ = false;
  double given_ = 0;      // kinetic and elastic energy at the start, and all work since [J]
  double potential_ = 0;  // in gravity, at the start [J]
};

}  // namespace clothsim
