#pragma once

#include <optional>
#include <string>
#include <vector>

#include "clothsim/scene/scene.h"
#include "scenes.h"

namespace clothsim::work_precision {

/// A method and how hard it tries.
struct Dial {
  std::string method;               // `auto` or one of method_names()
  std::optional<int> substeps;      // a frame; empty: as `auto` counts them
  std::optional<int> iterations{};  // a substep, where the method has that parameter
  bool is_single = false;           // Verlet's precision

  /// As tables and charts have it.
  std::string name() const { return is_single ? method + "_single" : method; }
};

/// The scene with the method turned to `dial`.
Scene at(Scene, const Dial&);

/// The same with the method's iterations carried to convergence, so that only its scheme's error is
/// left. Empty for methods that do not iterate. XPBD converges to implicit Euler.
std::optional<Scene> converged(Scene, const Dial&);

/// `auto`, every method, and Verlet in single precision, from its coarsest step to its finest:
/// explicit ones from a fourth of what Verlet's limit asks for, those that solve by Newton's method
/// to the trial's `max_newton_substeps`. Quick: few and cheap.
std::vector<Dial> dials(const Trial&, bool quick);

}  // namespace clothsim::work_precision
