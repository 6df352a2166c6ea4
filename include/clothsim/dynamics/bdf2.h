#pragma once

#include <limits>
#include <vector>

#include "clothsim/dynamics/cloth_watch.h"
#include "clothsim/dynamics/forces.h"
#include "clothsim/dynamics/newton_solver.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// The backward differentiation formula of two steps, 3 x' - 4 x + x_last = 2 h v', the same for v.
/// Second order, stable at any step, damps fast swings. Hairer & Wanner, Solving Ordinary
/// Differential Equations II, V.1; for cloth, Choi & Ko 2002, "Stable but responsive cloth".
///
/// History belongs to a point. Without one (at the start, after h or the material has changed) it
/// takes a step of implicit Euler, which costs no order. Constraints that pull on and on change
/// each state handed back by about as much as the one before: they act as forces do, and history
/// stays. A change more than three times larger or smaller than the last, or turned, is a hit, and
/// that point's history is dropped: else a third of the jump would come again in the next step.
///
/// Drag: v is replaced by exp(c t) v, and the force's weight 2 h / 3 by (1 - e)(3 - e) / 3 c with
/// e = exp(-c h), so that drag alone and the end speed of a fall are exact for velocities.
class Bdf2 {
 public:
  static constexpr const char* name = "bdf2";
  static constexpr int order = 2;
  static constexpr double stability_limit = std::numeric_limits<double>::infinity();
  static constexpr double reach = 2.0 / 3;  // share of h that a point moves with a step's impulse

  struct Parameters : NewtonSolver::Parameters {};

  Bdf2() : Bdf2(Parameters()) {}
  explicit Bdf2(const Parameters& parameters) : solver_(parameters) {}

  /// Advances positions and velocities by h [s]; the caller keeps the time.
  void step(const Cloth&, const Loads&, double h, State&);

 private:
  /// What the caller did to a state since it was returned.
  struct Changes {
    Points positions;   // [m], N x 3
    Points velocities;  // [m/s], N x 3
  };

  void drop_history_of_hit_points(const State&);

  NewtonSolver solver_;
  ClothWatch watch_;
  std::vector<char> has_history_;  // by point
  State last_;                     // as the last step found it
  State returned_;                 // as the last step left it
  Changes changes_;                // made after the step before the last
  Scalars weights_;                // [N/m], N
  Points displacement_;            // by the springs [m], N x 3
};

}  // namespace clothsim
