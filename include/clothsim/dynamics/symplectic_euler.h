#pragma once

#include "clothsim/dynamics/forces.h"
#include "clothsim/dynamics/verlet.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// v += h f(x) / m, x += h v. First order, symplectic without drag; stable for h < 2 / omega_max.
/// Hairer, Lubich & Wanner, Geometric Numerical Integration, I.1.2.
///
/// Its positions are those of Verlet's method, its velocities belong half a step earlier, except in
/// a fall, which is exact. Drag is solved exactly for velocities: v = v exp(-c h) + (f / m) (1 -
/// exp(-c h)) / c.
class SymplecticEuler {
 public:
  static constexpr const char* name = "symplectic_euler";
  enum { order = 1 };
  static constexpr double stability_limit = VelocityVerlet::stability_limit;  // h omega_max
  static double displacement_factor(double, double) { return 1; }             // see Integrator

  struct Parameters {
    template <typename Self, typename Visit>
    static void each(Self&, Visit&&) {}
  };

  SymplecticEuler() = default;
  explicit SymplecticEuler(const Parameters&) {}

  /// Advances positions and velocities by h [s]; the caller keeps the time.
  void step(const Cloth&, const Loads&, double h, State&, const Workers& = {});

  static constexpr bool unconverged() { return false; }  // see Integrator

 private:
  Points forces_;  // [N], N x 3
};

}  // namespace clothsim
