#pragma once

#include <optional>
#include <string>
#include <vector>

#include "clothsim/scene/scene.h"
#include "scenes.h"

namespace clothsim::work_precision {

/// A method with its accuracy settings.
struct Dial {
  std::string method;               // `auto` or one of method_names()
  std::optional<int> substeps;      // per frame; empty: as counted by `auto`
  std::optional<int> iterations{};  // per substep, for methods with that parameter
  bool is_single = false;           // Verlet's precision

  /// The name in tables and charts.
  std::string name() const { return is_single ? method + "_single" : method; }
};

/// The scene with the method of `dial`.
Scene at(Scene, const Dial&);

/// The same with the method's iterations to convergence, so that only the error of its scheme is
/// left. Empty for methods that do not iterate. XPBD converges to implicit Euler.
std::optional<Scene> converged(Scene, const Dial&);

/// `auto`, every method, and Verlet in single precision, from the coarsest step to the finest:
/// explicit methods from a fourth of the substeps of Verlet's limit on, methods with Newton's
/// method up to the trial's `max_newton_substeps`. `quick`: few and cheap ones.
std::vector<Dial> dials(const Trial&, bool quick);

}  // namespace clothsim::work_precision
