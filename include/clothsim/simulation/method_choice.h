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
  /// Predicted error of positions after half a second of falling, divided by the cloth's size. Set
  /// for `auto` only.
  std::optional<double> predicted_error = {};
  /// CPU seconds per simulated second, on one core of a current CPU. For a method that the scene
  /// names, it does not include the impulses of contact and the strain limit.
  std::optional<double> predicted_cost = {};
};

/// The method for `simulation.method`. A name selects that method. `auto` selects the cheapest
/// method that stays within `simulation.tolerance` in real time; if none does, the most accurate in
/// real time; if none is in real time, the cheapest. A given count of substeps is kept. Without
/// gravity, and where a stiff cloth rings (has fast waves in which errors grow), its motion cannot
/// be predicted, and neither can the error. Then `auto` prefers an explicit method in real time,
/// since it conserves energy and momenta, else one that does not soften springs. Where XPBD is
/// taken and stretches a cloth without strain limit by 3 % or more, a reason says by how much.
///
/// The result depends on the arguments alone, so that equal scenes give equal bits on every
/// machine: costs per spring or point are constants, not measured at run time. Errors are those of
/// the integration of a cloth that starts as in the scene and falls, swings or buckles; the strain
/// limit and contact have tolerances of their own.
MethodChoice choose_method(const SimulationSpec&, const Cloth&, const std::vector<ColliderSpec>&);

}  // namespace clothsim
