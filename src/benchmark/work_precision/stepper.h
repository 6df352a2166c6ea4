#pragma once

#include <functional>
#include <memory>

#include "clothsim/model/state.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim::work_precision {

/// A simulation of a cloth, frame by frame: the simulator, or a peer.
class Stepper {
 public:
  virtual ~Stepper() = default;

  /// Simulates one frame. Throws Diverged.
  virtual StepReport step() = 0;
  virtual const State& state() const = 0;
};

/// Makes a new stepper each time, for repeated runs.
using StepperMaker = std::function<std::unique_ptr<Stepper>()>;

StepperMaker simulator_of(const Scene&);

}  // namespace clothsim::work_precision
