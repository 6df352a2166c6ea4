#pragma once

#include <vector>

#include "clothsim/dynamics/bends.h"
#include "clothsim/model/cloth.h"

namespace clothsim {

/// Internal damping in implicit steps: rates are differences to the past, for a spring's length l
/// as (l - l_past) / time. The potential of a step then has, in addition to springs k (l - L0)^2 /
/// 2, those of (k tau / time) (l - l_past)^2 / 2: together one spring again, see damped(); for a
/// triangle of a mesh K tau / time by squared lengths; and for a bend the square of the change of b
/// along u, see BendPast. As it acts on lengths, damping of springs and triangles does not affect
/// rigid rotation. Kane et al. 2000, "Variational integrators and the Newmark algorithm", for
/// dissipation.
struct Past {
  /// A stencil's sum b as it was, along the direction u that earlier positions predict for the
  /// step's end. A fixed direction keeps the potential convex; that the direction turns within the
  /// step is an error of the method's own order.
  struct BendPast {
    Vector3 u;      // 0 where b is
    double length;  // u . b_past [m], of a mesh without unit
  };

  double time = 0;              // [s]
  std::vector<double> lengths;  // of the springs, in the order of for_each_spring [m]
  std::vector<double> squares;  // of a mesh instead: of edges, their squared lengths [m^2]
  std::vector<BendPast> bends;  // in the order of for_each_bend; empty without damping of bends

  bool empty() const { return time == 0; }
};

/// The past of an implicit step of h [s] from `positions`; empty without internal damping.
Past past_of(const Cloth&, const Points& positions, double h);

/// The same for the formula 3 x' - 4 x + x_last = 2 h v' of two steps.
Past past_of(const Cloth&, const Points& positions, const Points& last, double h);

/// A spring with its damping, over `time` [s] since it was `past` [m] long.
struct DampedSpring {
  double stiffness;    // [N/m]
  double rest_length;  // [m]
};
inline DampedSpring damped(const SpringRun& run, double damping, double past, double time) {
  const double share = damping / time;
  return {run.stiffness * (1 + share), (run.rest_length + share * past) / (1 + share)};
}

/// Calls visit(bend, past of the bend) for every stencil of damped bends.
template <typename Visitor>
void for_each_damped_bend(const Cloth& cloth, const Past& past, Visitor&& visit) {
  if (past.bends.empty()) return;
  std::size_t id = 0;
  for_each_bend(cloth, [&](const auto& bend) { visit(bend, past.bends[id++]); });
}

/// Sum of (k tau / time) (l - l_past)^2 / 2 over the springs, plus the same for bends [J].
double damping_potential(const Cloth&, const Past&, const Points& positions);

/// Adds its derivative by positions [N].
void add_damping_gradient(const Cloth&, const Past&, const Points& positions, Points& gradient);

}  // namespace clothsim
