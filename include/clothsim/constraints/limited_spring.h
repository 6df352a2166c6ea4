#pragma once

#include <cstddef>
#include <cstdint>

namespace clothsim {

/// A point's x, y and z side by side, and a fourth number, 0: kernels that go from point to point
/// load and store all at once.
struct alignas(32) Quad {
  double x, y, z, w;
};

/// Four springs at their strain limit, no two of which share a point, number by number: kernels
/// take all four at once, and a few hundred stay in the nearest cache. Where there are fewer, the
/// rest are zero, with both ends at a point that no spring has.
struct alignas(32) FourSprings {
  static constexpr std::size_t count = sizeof(Quad) / sizeof(double);

  double x[count], y[count], z[count];  // direction from a to b; 0 for no spring
  double velocity_impulse[count];       // impulse over the reduced mass of both ends [m/s], >= 0
  double before[count];                 // the velocity impulses before the last pass
  double max_rate[count];               // largest rate of elongation allowed [m/s]
  double share[count];                  // of a velocity impulse, for a
  double mass[count];                   // reduced, of both ends [kg]; 0 for no spring
  unsigned a[count];  // points, as place() has them: an address is one instruction
  unsigned b[count];

  /// Index of a point's first number.
  static unsigned place(int point) { return 4 * static_cast<unsigned>(point); }
  static int point(unsigned place) { return static_cast<int>(place / 4); }
};

/// How impulses act in a step of h [s]; see StrainLimit and Integrator.
struct LimitStep {
  double h;
  double displacement_factor;
  double active;  // share of all springs that are at their limit
  double rate;    // at which a violation is corrected [1/s]
};

/// Scales velocity impulses, gives them to the points, and stores `velocity_impulses` [m/s] and
/// `masses` [kg] by spring; their products are the impulses.
void warm_start_springs(double scale, std::size_t fours, FourSprings* springs,
                        double* velocity_impulses, double* masses, Quad* velocities);

/// Input for turning springs' impulses to their present directions. Positions, with inverse masses,
/// and velocities by point; by spring its length at the limit [m], and the velocity impulse and
/// mass of its impulse. `before`: velocities at the step's start, to distinguish turning from
/// velocity impulses; null: all counts as turning.
struct Turn {
  const Quad* positions;
  const Quad* velocities;
  const Quad* before;
  const double* longest;
  const double* velocity_impulses;
  const double* masses;
};

/// Sets directions in the middle of the step, and the rates of elongation allowed. Gives the points
/// their impulses along these directions.
void prepare_springs(LimitStep, const Turn&, std::size_t fours, FourSprings* springs,
                     Quad* velocities);

/// Adds T h / l [N s/m] of springs to both their points.
void add_tensions(const FourSprings* springs, const double* longest, std::size_t fours,
                  double* tensions);

/// Changes in a pass.
struct PassChange {
  double largest = 0;  // of a rate of elongation [m/s]
  double descent = 0;  // sum of changes times differences to the pass before; < 0: uphill

  void add(const PassChange& other) {
    largest = largest < other.largest ? other.largest : largest;
    descent += other.descent;
  }
};

/// Half a pass of projected Gauss-Seidel, in the order given, with velocity impulses of up to
/// `max_impulse` [m/s]. It starts from velocity impulses extrapolated by `momentum` times the
/// change of the last pass; the velocities must be extrapolated alike. A half pass back keeps the
/// start of the one forth for the next extrapolation.
PassChange solve_springs(FourSprings* springs, std::size_t fours, double momentum, bool goes_back,
                         double max_impulse, Quad* velocities);

/// Extrapolates velocities by `momentum` times their change since `last`, and sets `last` to the
/// velocities before that.
void extrapolate(double momentum, std::size_t count, Quad* last, Quad* velocities);

/// Is any longer than `share` of its limit?
bool any_longer(const FourSprings* springs, const double* longest, std::size_t fours, double share,
                const Quad* positions);

/// Bit i: is spring (i, i + offset) longer than sqrt(longest2)? i in [0, count), `count` at
/// most 64.
std::uint64_t longer_bits(const double* x, const double* y, const double* z, int offset, int count,
                          double longest2);

}  // namespace clothsim
