#pragma once

#include <cmath>

#include "clothsim/dynamics/forces.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// The classical Runge-Kutta method. Fourth order, four forces a step; stable for h < sqrt(8) /
/// omega_max, where it takes energy out of fast oscillations: a step keeps the share 1 - z^6 / 72 +
/// z^8 / 576, with z = h omega. Hairer, Norsett & Wanner, Solving Ordinary Differential Equations
/// I, II.1.
///
/// Drag enters by its integrating factor: the method is applied to exp(c t) v (Lawson 1967,
/// "Generalized Runge-Kutta processes"), so drag alone gives v0 exp(-c t) whatever the step.
class RungeKutta4 {
 public:
  static constexpr const char* name = "rk4";
  enum { order = 4 };
  enum { limit_squared = 8 };
  static inline const double stability_limit = std::sqrt(double{limit_squared});  // h omega_max
  static double displacement_factor(double damping, double h);                    // see Integrator

  struct Parameters {
    template <typename Self, typename Visit>
    static void each(Self&, Visit&&) {}
  };

  RungeKutta4() = default;
  explicit RungeKutta4(const Parameters&) {}

  /// Advances positions and velocities by h [s]; the caller keeps the time.
  void step(const Cloth&, const Loads&, double h, State&, const Workers& = {});

  static constexpr bool unconverged() { return false; }  // see Integrator

 private:
  Points forces_;                          // [N], N x 3
  Points x_, v_;                           // of the stage
  Points end_positions_, end_velocities_;  // sums over the stages
};

}  // namespace clothsim
