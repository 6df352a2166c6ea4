#pragma once

#include <optional>
#include <string>
#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/scene/scene.h"
#include "clothsim/simulation/reasons.h"

namespace clothsim {

/// The integration chosen for a scene.
struct MethodChoice {
  std::string method;    // a name of method_names()
  int min_substeps = 1;  // per frame, whatever the state
  Reasons reasons;
  bool is_feasible = true;  // stable and, as predicted, in real time
  /// Predicted error of positions after half a second of falling, over the cloth's size. For `auto`
  /// only.
  std::optional<double> predicted_error = {};
  /// CPU seconds per simulated second on a present core. For a method that the scene names, without
  /// impulses of contact and the strain limit.
  std::optional<double> predicted_cost = {};
};

/// The method for `simulation.method`. A name: that method. `auto`: the cheapest method that stays
/// within `simulation.tolerance` in real time; if none does, the most accurate in real time; if
/// none is in real time, the cheapest. A given count of substeps is kept. Where the motion of the
/// cloth cannot be predicted, without gravity or where a stiff one rings, no error is predicted:
/// then an explicit method, which conserves energy and momenta, where one is in real time.
///
/// A function of its arguments alone, so that equal scenes give equal bits on every machine: costs
/// are known per spring or point, not measured at run time. Errors are those of the integration of
/// a cloth that starts as in the scene and falls, swings or buckles; the strain limit and contact
/// have tolerances of their own.
MethodChoice choose_method(const SimulationSpec&, const Cloth&, const std::vector<ColliderSpec>&);

}  // namespace clothsim
