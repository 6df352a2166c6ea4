#pragma once

#include "clothsim/dynamics/forces.h"
#include "clothsim/dynamics/newton_solver.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// v += h f(x') / m, x' = x + h v, with the forces of the step's end. First order, stable at any
/// step; an oscillator of frequency omega loses the share 1 - 1 / sqrt(1 + h^2 omega^2) of its
/// amplitude in a step. Hairer & Wanner, Solving Ordinary Differential Equations II, IV.3; for
/// cloth, Baraff & Witkin 1998, "Large steps in cloth simulation".
///
/// Drag is solved exactly for velocities: v = v exp(-c h) + (f / m) (1 - exp(-c h)) / c.
class ImplicitEuler {
 public:
  static constexpr const char* name = "implicit_euler";
  enum { order = 1 };
  static constexpr double stability_limit = infinity;
  static double displacement_factor(double, double) { return 1; }  // see Integrator

  struct Parameters : NewtonSolver::Parameters {};

  ImplicitEuler() : ImplicitEuler(Parameters()) {}
  explicit ImplicitEuler(const Parameters& parameters) : solver_(parameters) {}

  /// Advances positions and velocities by h [s]; the caller keeps the time.
  void step(const Cloth&, const Loads&, double h, State&, const Workers& = {});

  bool unconverged() const { return solver_.unconverged(); }  // see Integrator

 private:
  NewtonSolver solver_;
  Points displacement_;  // by the springs [m], N x 3
};

}  // namespace clothsim
