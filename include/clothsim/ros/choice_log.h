#pragma once

#include "clothsim/scene/scene.h"
#include "clothsim/simulation/method_choice.h"

namespace clothsim_ros {

/// Logs the choice of `method: auto`, and its changes.
class ChoiceLog {
 public:
  /// To be called often.
  void update(const clothsim::SimulationSpec&, const clothsim::MethodChoice&);

 private:
  clothsim::MethodChoice told_;
};

}  // namespace clothsim_ros
