#pragma once

#include <algorithm>

#include "clothsim/dynamics/energy.h"
#include "verification/testing.h"

namespace clothsim::testing {

/// Energy of motion that a cloth makes of nothing while nothing is driven: what motion and height
/// gain, and drag has taken, beyond what springs have given. No cloth can; a method is off by some
/// share of what moves. What springs take is no motion: what is over its limit is drawn back, and
/// what is in a collider pushed out, against springs; methods that solve these not to the end, or
/// before contact, show more in them than ever comes out. As soon as it does, it is counted.
class EnergyAccount {
 public:
  /// Begins anew with the state that a simulator is in.
  void begin(const Simulator& simulator) {
    motion_ = motion(simulator);
    elastic_ = elastic(simulator);
    kinetic_ = kinetic_energy(simulator.cloth(), simulator.state());
    taken_ = 0;
    scale_ = kinetic_ + elastic_ + fall(simulator);
  }

  /// To be called after each frame; the share made since begin(), of all that could move.
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

  /// Kinetic energy and that in gravity [J].
  static double motion(const Simulator& simulator) {
    const Vector3& gravity = simulator.scene().simulation.gravity;
    return kinetic_energy(simulator.cloth(), simulator.state()) +
           gravitational_energy(simulator.cloth(), gravity, simulator.state().positions);
  }

  /// What a fall by its size gives [J].
  static double fall(const Simulator& simulator) {
    const ClothSpec& spec = simulator.scene().cloth;
    return simulator.cloth().mass.sum() * simulator.scene().simulation.gravity.norm() *
           std::hypot(spec.width, spec.height);
  }

  double motion_ = 0;   // as it began [J]
  double elastic_ = 0;  // as it began [J]
  double kinetic_ = 0;  // as the last frame ended [J]
  double taken_ = 0;    // by drag [J]
  double scale_ = 0;    // [J]
};

}  // namespace clothsim::testing
