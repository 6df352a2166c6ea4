#pragma once

#include "clothsim/dynamics/forces.h"
#include "clothsim/model/checks.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// Stoermer-Verlet as drift, kick, drift. Second order, symplectic without drag; stable for h < 2 /
/// omega_max; an oscillator of frequency omega oscillates at w with sin(w h / 2) = omega h / 2.
/// Hairer, Lubich & Wanner, Geometric Numerical Integration, I.1.4.
///
/// The drift form needs one force a step, wherever constraints and contact have put the points
/// since the last one; kick, drift, kick (its conjugate, with the same limit and frequency) would
/// need a second. Drag is solved exactly within each drift, and with it a constant force: a fall is
/// exact, and drag alone gives v0 exp(-c t) and x0 + v0 (1 - exp(-c t)) / c, whatever the step.
/// Pins move at their own velocity. Internal damping uses the velocities at the step's start: half
/// a step late, so the energy that it takes is accurate to first order.
class VelocityVerlet {
 public:
  static constexpr const char* name = "verlet";
  enum { order = 2 };
  enum { limit = 2 };
  static constexpr double stability_limit = limit;              // h omega_max
  static double displacement_factor(double damping, double h);  // see Integrator

  struct Parameters {
    /// For the springs' forces. Positions and velocities are always double.
    enum Precision : int { double_precision, single_precision };
    Precision precision = double_precision;

    template <typename Self, typename Visit>
    static void each(Self& self, Visit&& visit) {
      visit("precision", self.precision, Range{double_precision, single_precision, ""});
    }
  };

  VelocityVerlet() = default;
  explicit VelocityVerlet(const Parameters& parameters) : parameters_(parameters) {}

  /// Advances positions and velocities by h [s]; the caller keeps the time.
  void step(const Cloth&, const Loads&, double h, State&, const Workers& = {});

  static constexpr bool unconverged() { return false; }  // see Integrator

 private:
  void step_mesh(const Cloth&, const Loads&, double h, State&, const Workers&);
  template <typename Forces>
  void step_by(Forces&, const Cloth&, const Loads&, double h, State&, const Workers&);
  const Points* damped_velocities(const Cloth&, const Points& middle, const Points& velocities,
                                  const Workers&);

  Parameters parameters_;
  Points middle_;      // positions in the middle of the step [m], N x 3; empty with one thread
  Points velocities_;  // for internal damping [m/s], N x 3, see remove_rotation()
  Scalars forces_;     // along one axis [N], N; empty in single precision
  Eigen::VectorXf single_forces_;  // the same in single precision
  Points mesh_forces_;             // of a mesh [N], N x 3
};

}  // namespace clothsim
