#pragma once

#include <array>
#include <cstddef>

#include "clothsim/dynamics/xpbd_lines.h"

namespace clothsim {

template <typename Number>
using Axes = std::array<Number, 3>;

/// A bundle and the numbers of its solution, by point or by spring along the lines.
struct LineRows {
  int springs;
  const LanePoints* points;
  const Lanes* inv_mass;
  const Lanes* compliance;
  const Lanes* target;
  Lanes* lambda;
  Axes<Lanes*> at;     // positions
  Axes<Lanes*> u;      // directions, then impulses on first ends
  Axes<Lanes*> moves;  // of points
  Lanes* lengths;
  Lanes* pivots;     // then their inverse
  Lanes* couplings;  // to the spring before, then force densities
  Lanes* changes;    // of lambda, then couplings to the point after
};

/// Takes the lines' points from a column of positions.
void load_points(const LineRows&, const double* x, int axis);
/// Sets directions, pivots and changes, those of springs alone.
void measure_springs(const LineRows&);
/// Sets the changes of the multipliers by elimination (Thomas). The matrix is positive definite, as
/// compliances are positive and no direction is longer than 1; rounding might take pivots below the
/// compliances, which are lower bounds of them.
void eliminate(const LineRows&);
/// Adds the changes to the multipliers, and sets impulses. A tension has the force density q =
/// -dlambda / l, with l the length that it leads to, at least half of the present one; its impulse
/// on the first end is q times the vector to the second one. A pressure has the impulse dlambda in
/// the present direction.
void set_impulses(const LineRows&);
/// Moves points by the impulses of the springs on both sides, those of tensions along the springs'
/// directions at the end: (1 + w (q_k-1 + q_k)) dx_k - w q_k-1 dx_k-1 - w q_k dx_k+1 = w (f_k -
/// f_k-1), by elimination.
void move_points(const LineRows&);
/// Makes the impulses of tensions those at the moved points.
void turn_impulses(const LineRows&);
/// Writes the points of the first `lines` lines to a column of positions.
void store_points(const LineRows&, std::size_t lines, int axis, double* x);

}  // namespace clothsim
