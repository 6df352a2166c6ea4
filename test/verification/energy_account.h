#pragma once

#include "clothsim/dynamics/energy.h"
#include "verification/testing.h"

namespace clothsim::testing {

/// Energy that a cloth makes of nothing while nothing is driven: what it gains, and what drag has
/// taken. No cloth can; a method is off by some share of what moves.
class EnergyAccount {
 public:
  /// Begins anew with the state that a simulator is in.
  void begin(const Simulator& simulator) {
    start_ = energy(simulator);
    kinetic_ = kinetic_energy(simulator.cloth(), simulator.state());
    taken_ = 0;
    scale_ =
        kinetic_ + elastic_energy(simulator.cloth(), simulator.state().positions) + fall(simulator);
  }

  /// To be called after each frame; the share made since begin(), of all that could move.
  double share_made(const Simulator& simulator) {
    const double kinetic = kinetic_energy(simulator.cloth(), simulator.state());
    taken_ += simulator.cloth().damping * (kinetic_ + kinetic) * simulator.frame_duration();
    kinetic_ = kinetic;
    return (energy(simulator) - start_ + taken_) / scale_;
  }

 private:
  static double energy(const Simulator& simulator) {
    const Loads loads{simulator.scene().simulation.gravity};
    return total_energy(simulator.cloth(), loads, simulator.state());
  }

  /// What a fall by its size gives [J].
  static double fall(const Simulator& simulator) {
    const ClothSpec& spec = simulator.scene().cloth;
    return simulator.cloth().mass.sum() * simulator.scene().simulation.gravity.norm() *
           std::hypot(spec.width, spec.height);
  }

  double start_ = 0;    // [J]
  double kinetic_ = 0;  // as the last frame ended [J]
  double taken_ = 0;    // by drag [J]
  double scale_ = 0;    // [J]
};

}  // namespace clothsim::testing
