#include "clothsim/constraints/limited_spring.h"

#include <algorithm>
#include <cmath>

#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// Largest share of a violation that a step corrects. Warm-started impulses integrate it, so a
/// large share overshoots where passes stop early, most where most springs are at their limit:
/// there the share is smaller, divided by 1 + 3 times the share of active springs, as this one
/// would ring for ever.
constexpr double max_violation_share = 0.008;

/// Largest share of its length by which a spring is shortened in a step for turning: that of a turn
/// by 0.1. Beyond, the middle of a step says too little about its end.
constexpr double max_turning_share = 0.005;

/// Four numbers as a vector register.
using Vector = double __attribute__((vector_size(32), may_alias));

using LooseVector = double __attribute__((vector_size(32), aligned(8), may_alias));

[[gnu::always_inline]] inline Vector& vector(Quad& q) { return reinterpret_cast<Vector&>(q); }
[[gnu::always_inline]] inline const Vector& vector(const Quad& q) {
  return reinterpret_cast<const Vector&>(q);
}
[[gnu::always_inline]] inline Vector& vector(double (&four)[4]) {
  return reinterpret_cast<Vector&>(four);
}
[[gnu::always_inline]] inline const Vector& vector(const double (&four)[4]) {
  return reinterpret_cast<const Vector&>(four);
}

/// The numbers of the four springs at `i`; `numbers` may begin anywhere.
[[gnu::always_inline]] inline const LooseVector& four_at(const double* numbers, std::size_t i) {
  return reinterpret_cast<const LooseVector&>(numbers[4 * i]);
}

[[gnu::always_inline]] inline LooseVector& four_at(double* numbers, std::size_t i) {
  return reinterpret_cast<LooseVector&>(numbers[4 * i]);
}

/// A vector in space for each of four springs.
struct Four {
  Vector x, y, z;
};

/// The ends of four springs, as Quad or const Quad.
template <typename Point>
struct Ends {
  [[gnu::always_inline]] Ends(const FourSprings& s, Point* points) {
    for (int i = 0; i < 4; ++i) {
      a[i] = reinterpret_cast<Point*>(&points->x + s.a[i]);
      b[i] = reinterpret_cast<Point*>(&points->x + s.b[i]);
    }
  }
  Point* a[4];
  Point* b[4];
};

[[gnu::always_inline]] inline void set_dot(const Four& a, const Four& b, Vector& dot) {
  dot = a.x * b.x + a.y * b.y + a.z * b.z;
}

/// Differences from the first to the second ends.
template <typename Point>
[[gnu::always_inline]] inline void gather_differences(const Ends<Point>& ends, Four& four) {
  const Vector p = vector(*ends.b[0]) - vector(*ends.a[0]);
  const Vector q = vector(*ends.b[1]) - vector(*ends.a[1]);
  const Vector r = vector(*ends.b[2]) - vector(*ends.a[2]);
  const Vector s = vector(*ends.b[3]) - vector(*ends.a[3]);
  const Vector pq_xz = __builtin_shufflevector(p, q, 0, 4, 2, 6);
  const Vector pq_y = __builtin_shufflevector(p, q, 1, 5, 3, 7);
  const Vector rs_xz = __builtin_shufflevector(r, s, 0, 4, 2, 6);
  const Vector rs_y = __builtin_shufflevector(r, s, 1, 5, 3, 7);
  four.x = __builtin_shufflevector(pq_xz, rs_xz, 0, 1, 4, 5);
  four.y = __builtin_shufflevector(pq_y, rs_y, 0, 1, 4, 5);
  four.z = __builtin_shufflevector(pq_xz, rs_xz, 2, 3, 6, 7);
}

/// Changes the rates of elongation by -`velocity_impulse`.
[[gnu::always_inline]] inline void give(const FourSprings& s, const Vector& velocity_impulse,
                                        const Ends<Quad>& ends) {
  const Vector zero = {};
  const Vector xy_02 = __builtin_shufflevector(vector(s.x), vector(s.y), 0, 4, 2, 6);
  const Vector xy_13 = __builtin_shufflevector(vector(s.x), vector(s.y), 1, 5, 3, 7);
  const Vector z_02 = __builtin_shufflevector(vector(s.z), zero, 0, 4, 2, 6);
  const Vector z_13 = __builtin_shufflevector(vector(s.z), zero, 1, 5, 3, 7);
  const Vector direction[] = {__builtin_shufflevector(xy_02, z_02, 0, 1, 4, 5),
                              __builtin_shufflevector(xy_13, z_13, 0, 1, 4, 5),
                              __builtin_shufflevector(xy_02, z_02, 2, 3, 6, 7),
                              __builtin_shufflevector(xy_13, z_13, 2, 3, 6, 7)};
  for (int i = 0; i < 4; ++i) {
    const Vector both = velocity_impulse[i] * direction[i];
    const Vector of_a = s.share[i] * both;
    vector(*ends.a[i]) += of_a;
    vector(*ends.b[i]) -= both - of_a;
  }
}

/// Differences between the ends of four springs where the step's impulses act, `back` [s] ago, and
/// their rates.
[[gnu::always_inline]] inline void gather_middle(const FourSprings& s, const Quad* positions,
                                                 const Quad* velocities, double back, Four& d,
                                                 Four& rates) {
  gather_differences(Ends(s, velocities), rates);
  gather_differences(Ends(s, positions), d);
  d.x -= back * rates.x;
  d.y -= back * rates.y;
  d.z -= back * rates.z;
}

[[gnu::always_inline]] inline void gather_inv_masses(const Ends<const Quad>& ends, Vector& of_a,
                                                     Vector& of_b) {
  for (int k = 0; k < 4; ++k) {
    of_a[k] = ends.a[k]->w;
    of_b[k] = ends.b[k]->w;
  }
}

/// Sets the masses of springs, 0 for inactive ones, and velocity impulses.
[[gnu::always_inline]] inline void carry(FourSprings& s, const Vector& mass,
                                         const LooseVector& velocity_impulse) {
  vector(s.velocity_impulse) = vector(s.before) = mass > 0 ? velocity_impulse : Vector{};
  vector(s.mass) = mass;
}

/// Bounds the correction for turning by the rate at which the spring lengthens with the velocities
/// `before` [m/s], of the step's start. A faster turn comes from a velocity impulse to which other
/// constraints have not responded yet: a correction for it would add energy.
[[gnu::always_inline]] inline void bound_by_lengthening(const FourSprings& s, const Quad* before,
                                                        const Four& direction, Vector& limit) {
  const Vector zero = {};
  Four start;
  Vector lengthens;
  gather_differences(Ends(s, before), start);
  set_dot(start, direction, lengthens);
  lengthens = lengthens < 0 ? zero : lengthens;
  limit = limit < lengthens ? limit : lengthens;
}

}  // namespace

CLOTHSIM_TARGET_CLONES
void warm_start_springs(double scale, std::size_t fours, FourSprings* springs,
                        double* velocity_impulses, double* masses, Quad* velocities) {
  for (std::size_t i = 0; i < fours; ++i) {
    FourSprings& s = springs[i];
    const Vector velocity_impulse = scale * vector(s.velocity_impulse);
    vector(s.velocity_impulse) = four_at(velocity_impulses, i) = velocity_impulse;
    four_at(masses, i) = vector(s.mass);
    give(s, velocity_impulse, Ends(s, velocities));
  }
}

CLOTHSIM_TARGET_CLONES
void prepare_springs(LimitStep step, const Turn& turn, std::size_t fours, FourSprings* springs,
                     Quad* points) {
  const auto [positions, velocities, before, longest, velocity_impulses, masses] = turn;
  const double back = step.displacement_factor * step.h;
  const double rate = 1 / step.h;
  const double share = std::min(step.rate * step.h, max_violation_share) / (1 + 3 * step.active);
  for (std::size_t i = 0; i < fours; ++i) {
    FourSprings& s = springs[i];
    // The ends when the step's impulses act: there they add no angular momentum.
    Four speed, d;
    gather_middle(s, positions, velocities, back, d, speed);
    Vector length2;
    set_dot(d, d, length2);
    Vector w_a, w_b;  // inverse masses, with added inertia
    gather_inv_masses(Ends(s, positions), w_a, w_b);
    // Others are slack, or between two pins, and have no direction.
    const auto is_long = length2 * (w_a + w_b) > 0;
    Vector length;
    for (int k = 0; k < 4; ++k) length[k] = std::sqrt(length2[k]);
    const Vector zero = {};
    const Vector inverse = is_long ? 1 / length : zero;
    const Four direction = {inverse * d.x, inverse * d.y, inverse * d.z};
    vector(s.x) = direction.x;
    vector(s.y) = direction.y;
    vector(s.z) = direction.z;
    const Vector mass = is_long ? 1 / (w_a + w_b) : zero;
    carry(s, mass, four_at(velocity_impulses, i) * (four_at(masses, i) / mass));
    vector(s.share) = w_a * mass;

    // Rate of elongation allowed: up to the limit within a step, negative if over it. A spring that
    // turns at speed v across grows by h^2 v^2 / (2 l) in a step if it may not lengthen in the
    // middle of it: half its centripetal acceleration v^2 / l, times h, corrects that.
    Vector along, across2;
    set_dot(speed, direction, along);
    const Four across = {speed.x - along * direction.x, speed.y - along * direction.y,
                         speed.z - along * direction.z};
    set_dot(across, across, across2);
    const Vector excess = length - four_at(longest, i);
    const Vector turning = (step.h / 2) * across2 * inverse;
    Vector turning_limit = max_turning_share * rate * length;
    if (before) bound_by_lengthening(s, before, direction, turning_limit);
    const Vector max_rate = (excess > 0 ? zero - share * rate : zero - rate) * excess -
                            (turning_limit < turning ? turning_limit : turning);
    vector(s.max_rate) = is_long ? max_rate : zero;
    give(s, vector(s.velocity_impulse), Ends(s, points));
  }
}

CLOTHSIM_TARGET_CLONES
void add_tensions(const FourSprings* springs, const double* longest, std::size_t fours,
                  double* tensions) {
  for (std::size_t i = 0; i < fours; ++i) {
    const FourSprings& s = springs[i];
    const Vector tension = vector(s.mass) * vector(s.velocity_impulse) / four_at(longest, i);
    for (std::size_t k = 0; k < FourSprings::count; ++k) {
      tensions[FourSprings::point(s.a[k])] += tension[k];
      tensions[FourSprings::point(s.b[k])] += tension[k];
    }
  }
}

CLOTHSIM_TARGET_CLONES
PassChange solve_springs(FourSprings* springs, std::size_t fours, double momentum, bool goes_back,
                         double max_impulse, Quad* velocities) {
  const Vector highest = {max_impulse, max_impulse, max_impulse, max_impulse};
  Vector largest = {}, descent = {};
  for (std::size_t i = 0; i < fours; ++i) {
    FourSprings& s = springs[i];
    const Ends ends(s, velocities);
    Four difference;
    gather_differences(ends, difference);
    Vector rate;
    set_dot({vector(s.x), vector(s.y), vector(s.z)}, difference, rate);
    const Vector velocity_impulse = vector(s.velocity_impulse), before = vector(s.before);
    const Vector from = velocity_impulse + momentum * (velocity_impulse - before);
    const Vector lower = -from;
    const Vector upper = highest - from;
    const Vector wanted = rate - vector(s.max_rate);
    const Vector free = lower < wanted ? wanted : lower;
    const Vector change = free < upper ? free : upper;
    const Vector now = from + change;
    const Vector start = goes_back ? before : velocity_impulse;
    vector(s.before) = start;
    vector(s.velocity_impulse) = now;
    const Vector size = change < 0 ? -change : change;
    largest = largest < size ? size : largest;
    descent += change * (now - start);
    give(s, change, ends);
  }
  return {std::max({largest[0], largest[1], largest[2], largest[3]}),
          (descent[0] + descent[1]) + (descent[2] + descent[3])};
}

CLOTHSIM_TARGET_CLONES
void extrapolate(double momentum, std::size_t count, Quad* last, Quad* velocities) {
  for (std::size_t i = 0; i < count; ++i) {
    const Vector now = vector(velocities[i]);
    vector(velocities[i]) = now + momentum * (now - vector(last[i]));
    vector(last[i]) = now;
  }
}

CLOTHSIM_TARGET_CLONES
bool any_longer(const FourSprings* springs, const double* longest, std::size_t fours, double share,
                const Quad* positions) {
  auto any = Vector{} > 1;
  for (std::size_t i = 0; i < fours; ++i) {
    const FourSprings& s = springs[i];
    Four d;
    gather_differences(Ends(s, positions), d);
    Vector length2;
    set_dot(d, d, length2);
    const Vector allowed = share * four_at(longest, i);
    any |= length2 > allowed * allowed;
  }
  return (any[0] | any[1] | any[2] | any[3]) != 0;
}

CLOTHSIM_TARGET_CLONES
std::uint64_t longer_bits(const double* x, const double* y, const double* z, int offset, int count,
                          double longest2) {
  using Words = std::uint64_t __attribute__((vector_size(sizeof(Half))));
  Words bits[2] = {}, places[2] = {{1, 2, 4, 8}, {16, 32, 64, 128}};
  int i = 0;
  for (; i + num_lanes <= count; i += num_lanes) {
    for (int half = 0; half < 2; ++half) {
      const int k = i + half * half_size;
      const Half dx = half_at(x + k + offset) - half_at(x + k);
      const Half dy = half_at(y + k + offset) - half_at(y + k);
      const Half dz = half_at(z + k + offset) - half_at(z + k);
      bits[half] |= dx * dx + dy * dy + dz * dz > longest2 ? places[half] : Words{};
      places[half] <<= num_lanes;
    }
  }
  const Words both = bits[0] | bits[1];
  std::uint64_t all = both[0] | both[1] | both[2] | both[3];
  for (; i < count; ++i) {
    const double dx = x[i + offset] - x[i];
    const double dy = y[i + offset] - y[i];
    const double dz = z[i + offset] - z[i];
    all |= std::uint64_t{dx * dx + dy * dy + dz * dz > longest2} << i;
  }
  return all;
}

}  // namespace clothsim
