#pragma once

#include <algorithm>

#include "clothsim/dynamics/energy.h"
#include "verification/testing.h"

namespace clothsim::test {

/// Energy of motion that a cloth gains from nothing while nothing is driven: the gain in kinetic
/// energy and in potential energy of gravity, plus the loss to drag, minus the energy released by
/// springs. For a cloth it is at most zero; a method errs by some share of the moving energy. An
/// increase in elastic energy does not count: the projections of springs over their limit and of
/// points in colliders work against springs, and a method that solves these incompletely, or before
/// contact, holds more energy in springs than they ever release. It counts once it is released.
class EnergyAccount {
 public:
  /// Starts again with the current state of a simulator.
  void begin(const Simulator& simulator) {
    motion_ = motion(simulator);
    elastic_ = elastic(simulator);
    kinetic_ = kinetic_energy(simulator.cloth(), simulator.state());
    taken_ = 0;
    scale_ = kinetic_ + elastic_ + fall(simulator);
  }

  /// To be called after each frame. The energy gained since begin(), as a share of the energy that
  /// could move.
  double share_made(const Simulator& simulator) {
    const double kinetic = kinetic_energy(simulator.cloth(), simulator.state());
    taken_ += simulator.cloth().damping * (kinetic_ + kinetic) * simulator.frame_duration();
    kinetic_ = kinetic;
    const double given = std::max(0.0, elastic_ - elastic(simulator));
    return (motion(simulator) - motion_ - given + taken_) / scale_;
  }

 private:
  static double elastic(const Simulator& simulator) {
    return elastic_energy(simulator.cloth(), simulator.state().positions);
  }

  /// Kinetic energy and potential energy of gravity [J].
  static double motion(const Simulator& simulator) {
    const Vector3& gravity = simulator.scene().simulation.gravity;
    return kinetic_energy(simulator.cloth(), simulator.state()) +
           gravitational_energy(simulator.cloth(), gravity, simulator.state().positions);
  }

  /// Energy of a fall by its size [J].
  static double fall(const Simulator& simulator) {
    const ClothSpec& spec = simulator.scene().cloth;
    return simulator.cloth().mass.sum() * simulator.scene().simulation.gravity.norm() *
           std::hypot(spec.width, spec.height);
  }

  double motion_ = 0;   // at the start [J]
  double elastic_ = 0;  // at the start [J]
  double kinetic_ = 0;  // at the end of the last frame [J]
  double taken_ = 0;    // lost to drag [J]
  double scale_ = 0;    // [J]
};

}  // namespace clothsim::test
