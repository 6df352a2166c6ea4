#pragma once

#include <limits>
#include <memory>

#include "clothsim/dynamics/forces.h"
#include "clothsim/model/checks.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// Implicit Euler solved by alternation: each spring alone takes its rest length, then one linear
/// solve brings all together. Bouaziz et al. 2014, "Projective dynamics"; for springs, Liu et al.
/// 2013, "Fast simulation of mass-spring systems". The matrix, inertia plus the springs' Laplacian,
/// is the same for x, y and z and in all steps; it is factorised again only when masses, springs,
/// drag or h change. One iteration is also a step of Newton's method with that matrix in the
/// Hessian's place (Liu, Bouaziz & Kavan 2017), which is how it is computed.
///
/// Anderson acceleration combines the last `window` iterates; an iterate that raises the potential
/// is dropped for the plain one (Peng et al. 2018, "Anderson acceleration for geometry
/// optimization"). Few iterations leave the cloth too soft and too much damped.
class ProjectiveDynamics {
 public:
  static constexpr const char* name = "projective_dynamics";
  static constexpr int order = 1;  // when converged
  static constexpr double stability_limit = std::numeric_limits<double>::infinity();
  static double reach(double, double) { return 1; }  // see Integrator

  struct Parameters {
    int iterations = 20;      // at most
    double tolerance = 1e-6;  // largest iteration at which it stops, of the longest rest length
    int window = 5;           // iterates combined; 0: no acceleration

    template <typename Self, typename Visit>
    static void each(Self& self, Visit&& visit) {
      visit("iterations", self.iterations, Range{1, 100000, ""});
      visit("tolerance", self.tolerance, Range{0, 1, ""});
      visit("window", self.window, Range{0, 20, ""});
    }
  };

  ProjectiveDynamics();
  explicit ProjectiveDynamics(const Parameters&);
  ~ProjectiveDynamics();
  ProjectiveDynamics(ProjectiveDynamics&&) noexcept;
  ProjectiveDynamics& operator=(ProjectiveDynamics&&) noexcept;

  /// Advances positions and velocities by h [s]; the caller keeps the time.
  void step(const Cloth&, const Loads&, double h, State&, const Workers& = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace clothsim
