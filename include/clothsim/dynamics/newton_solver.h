#pragma once

#include <memory>

#include "clothsim/dynamics/internal_damping.h"
#include "clothsim/model/checks.h"
#include "clothsim/model/cloth.h"

namespace clothsim {

/// Solves the equilibrium of springs and inertia: the displacements d of the free points that
/// minimise the incremental potential
///   sum_i w_i |d_i|^2 / 2 + sum over springs k (l(y + d) - L0)^2 / 2 + energy of bends,
/// as every implicit step does (Martin et al. 2011, "Example-based elastic materials", 3.2).
///
/// Newton's method with clamped spring Hessians, so that the matrix is positive definite, and
/// backtracking on the potential (Nocedal & Wright, Numerical Optimization, 3.1). Steps are
/// inexact, see SpringSystem: their error is some hundredth of them. Every step leaves the momentum
/// sum of w d of each piece of cloth without pins at zero.
class NewtonSolver {
 public:
  struct Parameters {
    double tolerance = 1e-3;  // largest Newton step at which it stops, of the longest rest length
    int max_iterations = 20;

    template <typename Self, typename Visit>
    static void each(Self& self, Visit&& visit) {
      visit("tolerance", self.tolerance, Range{1e-14, 1, ""});
      visit("max_iterations", self.max_iterations, Range{1, 1000, ""});
    }
  };

  explicit NewtonSolver(const Parameters&);
  ~NewtonSolver();
  NewtonSolver(NewtonSolver&&) noexcept;
  NewtonSolver& operator=(NewtonSolver&&) noexcept;

  /// `weights` [N/m] by point, above zero at free points; `y` [m], N x 3. Writes d [m], N x 3, zero
  /// at pins; NaN where the input has no positive definite matrix. `past`: for internal damping;
  /// empty: none. Returns the number of Newton steps.
  int solve(const Cloth&, const Scalars& weights, const Points& y, Points& d,
            const Past& past = {});

  /// Whether the last solve() ended before a step was as small as `tolerance`: at the maximum of
  /// iterations, or where no share of a step lowered the potential.
  bool unconverged() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace clothsim
