#pragma once

#include <cstddef>

namespace clothsim {

/// A point's x, y and z side by side and one number more: what a kernel that goes from point to
/// point loads and stores at once.
struct alignas(32) Quad {
  double x, y, z, w;
};

/// A spring at its strain limit, in one line of the caches.
struct alignas(64) LimitedSpring {
  Quad direction;  // from a to b; w is 0, and so is all of it where the spring has no direction
  double impulse;  // [N s], >= 0
  double mass;     // reduced, of both ends [kg]
  double fastest;  // largest rate of elongation allowed [m/s]
  int a;
  int b;
};

/// How impulses act in a step of h [s]; see StrainLimit and Integrator.
struct LimitStep {
  double h;
  double reach;
  double active;  // share of all springs that are at their limit
};

/// Directions in the middle of the step, and the rates of elongation allowed. Velocities and
/// positions by point; theirs w are 0. `longest`: by spring, its length at the limit [m].
void aim_springs(LimitStep, const Quad* positions, const Quad* velocities, const double* longest,
                 std::size_t count, LimitedSpring* springs);

/// Gives the points their impulses. Here and below velocities are by point, w the inverse mass
/// [1/kg].
void pull_points(const LimitedSpring* springs, std::size_t count, Quad* velocities);

/// One pass of projected Gauss-Seidel, in the order given. Returns the largest change of a rate of
/// elongation [m/s].
double sweep_springs(LimitedSpring* springs, std::size_t count, Quad* velocities);

/// Is any longer than `share` of its limit?
bool any_longer(const LimitedSpring* springs, const double* longest, std::size_t count,
                double share, const Quad* positions);

/// flags[i] = 1 where spring (i, i + offset) is longer than sqrt(longest2), else 0; i in [0,
/// count).
void flag_longer(const double* x, const double* y, const double* z, int offset, int count,
                 double longest2, unsigned char* __restrict flags);

}  // namespace clothsim
