#pragma once

#include <optional>
#include <string>
#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/scene/scene.h"
#include "clothsim/simulation/reasons.h"

namespace clothsim {

/// How a scene is going to be integrated.
struct MethodChoice {
  std::string method;    // a name of method_names()
  int min_substeps = 1;  // a frame, whatever the state
  Reasons reasons;
  bool is_feasible = true;  // stable and, as far as can be foretold, in real time
  /// Of positions after half a second of falling, of the cloth's size. Foretold by `auto` alone.
  std::optional<double> predicted_error = {};
  /// CPU seconds a simulated second on a core of today. Of a method that the scene names without
  /// impulses of contact and the strain limit.
  std::optional<double> predicted_cost = {};
};

/// What `simulation.method` stands for. A name: that method. `auto`: the cheapest method that stays
/// within `simulation.tolerance` in real time; if none does, the most accurate in real time; if
/// none is in real time, the cheapest. A given count of substeps is kept. Where nothing tells how
/// the cloth will move, without gravity or as a stiff one rings, no error is foretold: then an
/// explicit method, which keeps energy and momenta, where one is in real time.
///
/// A function of its arguments alone, so that equal scenes give equal bits on every machine: costs
/// are known per spring or point, not measured as it runs. Errors are those of the integration of a
/// cloth that starts as the scene has it and falls, swings or buckles; the strain limit and contact
/// have tolerances of their own.
MethodChoice choose_method(const SimulationSpec&, const Cloth&, const std::vector<ColliderSpec>&);

}  // namespace clothsim
