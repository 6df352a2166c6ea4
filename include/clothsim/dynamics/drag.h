#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "clothsim/dynamics/forces.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// Drag v' = -c v over t [s], solved exactly.
struct Drag {
  Drag(double c, double t)
      : decay(std::exp(-c * t)),
        distance(c > 0 ? -std::expm1(-c * t) / c : t),
        fall(fall_of(c, t, distance)) {}

  double decay;     // share of the velocity that is left
  double distance;  // travelled per unit of velocity, and velocity per unit of acceleration [s]
  double fall;      // travelled from rest per unit of acceleration [s^2]

 private:
  /// (t - distance) / c; by its series where the difference cancels, to 1e-13 of it.
  static double fall_of(double c, double t, double distance) {
    const double u = c * t;
    if (u > 0.01) return (t - distance) / c;
    return t * t * (1 - u / 3 * (1 - u / 4 * (1 - u / 5 * (1 - u / 6)))) / 2;
  }
};

/// Calls visit(begin, end, damping) for the parts of points [begin, end) that are of one cloth
/// each.
template <typename Visit>
void for_each_damping(const Cloth& cloth, int begin, int end, const Visit& visit) {
  if (cloth.dampings.empty()) return visit(begin, end, cloth.damping);
  for (std::size_t k = cloth.cloth_of(begin); begin < end; ++k) {
    const bool is_last = k + 1 == cloth.first_points.size();
    const int next = is_last ? end : std::min(end, cloth.first_points[k + 1]);
    visit(begin, next, cloth.dampings[k]);
    begin = next;
  }
}

/// A constraint's impulse acts at a substep's end, when drag has reduced the effect of forces in
/// its h [s]. A force through the whole substep with the effect of such an impulse has an impulse
/// that is larger by this factor.
inline double impulse_as_force(const Cloth& cloth, int point, double h) {
  return h / Drag(cloth.damping_at(point), h).distance;
}
/// The same for each point.
Scalars impulses_as_forces(const Cloth&, double h);

/// Displacement of a point in a step of h [s] by an acceleration through free_step() [s^2].
inline double free_step_time2(const Cloth& cloth, int point, double h) {
  return h * Drag(cloth.damping_at(point), h).distance;
}

/// Where loads act alone, adds to positions the difference of an exact fall with drag in a step of
/// h [s] to h v, with v the velocity at the step's end: with h v alone a cloth falls g h t / 2 too
/// deep in a time t. To be called at the step's start. A held cloth needs h v, or its rest position
/// would be off.
void add_fall(const Cloth&, const Loads&, double h, State&);

/// First half of the methods of implicit Euler's family: a step of h [s] without springs, v = v
/// exp(-c h) + g (1 - exp(-c h)) / c + loads.impulses, then x += h v, plus add_fall(). Pins keep
/// their velocity.
void free_step(const Cloth&, const Loads&, double h, State&);

/// Inertia m_i / (h (1 - exp(-c h)) / c) [N/m] of the points against springs that move them after
/// free_step(): m / h^2 without drag. Zero at pins.
Scalars free_step_weights(const Cloth&, double h);

}  // namespace clothsim
