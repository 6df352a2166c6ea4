#pragma once

#include "clothsim/dynamics/cloth_watch.h"
#include "clothsim/dynamics/forces.h"
#include "clothsim/dynamics/newton_solver.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// The backward differentiation formula of two steps, 3 x' - 4 x + x_last = 2 h v', the same for v.
/// Second order, stable at any step, damps fast oscillations. Hairer & Wanner, Solving Ordinary
/// Differential Equations II, V.1; for cloth, Choi & Ko 2002, "Stable but responsive cloth".
///
/// The history of a point is valid while nothing but the method moves it. A point without history
/// (at the start, after h or the material has changed, and after an impulse by the caller, as those
/// of contact and the strain limit) takes a step of implicit Euler: the difference v - v_last would
/// add a third of that impulse again. Single such steps do not lower the order; points that are
/// held all the time move at order 1, as impulses do.
///
/// Drag: v is replaced by exp(c t) v, and the force's weight 2 h / 3 by (1 - e)(3 - e) / 3 c with e
/// = exp(-c h), so that drag alone and the end speed of a fall are exact for velocities.
///
/// Internal damping uses rates by the formula in steps in which all free points have a history,
/// else over the one step.
class Bdf2 {
 public:
  static constexpr const char* name = "bdf2";
  enum { order = 2 };
  static constexpr double stability_limit = infinity;
  static double displacement_factor(double, double) { return 1; }  // see Integrator; if held

  struct Parameters : NewtonSolver::Parameters {};

  Bdf2() : Bdf2(Parameters()) {}
  explicit Bdf2(const Parameters& parameters) : solver_(parameters) {}

  /// Advances positions and velocities by h [s]; the caller keeps the time.
  void step(const Cloth&, const Loads&, double h, State&, const Workers& = {});

  /// The next step is as the first.
  void forget() { watch_ = {}; }

  bool unconverged() const { return solver_.unconverged(); }  // see Integrator

  /// The history, where it is valid for the cloth. `read` throws InvalidValue for data that is not
  /// from `write`.
  void write(MemoryWriter&, const Cloth&) const;
  void read(MemoryReader&, const Cloth&);

  /// To be called after read() where points of the cloth are held or let go since.
  void resume(const Cloth& cloth) {
    if (h_ > 0) watch_.changed(cloth, h_);
  }

 private:
  /// Largest component of free points' velocities before the last step and displacements per h in
  /// it [m/s].
  double max_speed_in_history(const Cloth&) const;
  /// Whether a point is where the last step left it.
  bool has_history(int i, const State& now) const;

  NewtonSolver solver_;
  ClothWatch watch_;
  double h_ = 0;         // of the last step [s]; 0: none
  State last_;           // as it was before the last step
  State returned_;       // as it was after the last step
  Points displacement_;  // by the springs [m], N x 3
};

}  // namespace clothsim
