#pragma once

#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// Internal damping in implicit steps: rates are differences to the past, for a spring's length l
/// as (l - l_past) / time, for strains of cells and positions alike, less a rotation
/// (remove_rotation()). The potential of a step then has, in addition to springs k (l - L0)^2 / 2,
/// those of (k tau / time) (l - l_past)^2 / 2: together one spring again, see damped(); for a cell
/// of a fabric by strains, for a triangle of a mesh K tau / time by squared lengths. Damping does
/// not resist rigid rotation. Kane et al. 2000, "Variational integrators and the Newmark
/// algorithm", for dissipation.
struct Past {
  double time = 0;              // [s]
  std::vector<double> lengths;  // of the springs, in the order of for_each_spring [m]
  std::vector<double> squares;  // of a mesh instead: of edges, their squared lengths [m^2]
  std::vector<double> strains;  // of cells, in the order of for_each_cell
  Points points;                // for bends [m], N x 3
  Points frame;                 // whose rotation bends follow [m], N x 3

  bool empty() const { return points.size() == 0; }
};

/// The past of an implicit step of h [s] from a state; empty without internal damping. Its frame is
/// in the middle of the step, where differences are rates to second order.
Past past_of(const Cloth&, const State&, double h);

/// The same for the formula 3 x' - 4 x + x_last = 2 h v' of two steps, of rates at the end.
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

/// Sum of (k tau / time) (l - l_past)^2 / 2 over the springs, plus the same for bends, of which the
/// changes d are relative to a rotation: d . d_relative, the least |d_relative|^2 of any rotation
/// [J]. The change of a bend is its derivative at Past::frame times the displacements.
double damping_potential(const Cloth&, const Past&, const Points& positions);

/// Adds its derivative by positions [N].
void add_damping_gradient(const Cloth&, const Past&, const Points& positions, Points& gradient);

}  // namespace clothsim
