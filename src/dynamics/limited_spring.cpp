#include "clothsim/dynamics/limited_spring.h"

#include <algorithm>
#include <cmath>

#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// Rate [1/s] at which the impulses work off a length violation, and the most of it in a step. Kept
/// impulses integrate the violation, so a large share overshoots where sweeps stop early, and worst
/// where most springs are at their limit: there it is a third of this, and this would ring for
/// ever.
constexpr double violation_rate = 5;
constexpr double most_of_violation = 0.008;

/// Largest share of its length that a spring is shortened in a step for turning: that of a turn by
/// 0.1. Beyond, the middle of a step says too little about its end.
constexpr double most_turning = 0.005;

/// Four numbers as the vector units see them.
using Vector = double __attribute__((vector_size(32), may_alias));

[[gnu::always_inline]] inline Vector& vector(Quad& q) { return reinterpret_cast<Vector&>(q); }
[[gnu::always_inline]] inline const Vector& vector(const Quad& q) {
  return reinterpret_cast<const Vector&>(q);
}

[[gnu::always_inline]] inline double dot(const Vector& a, const Vector& b) {
  const Vector c = a * b;
  return c[0] + c[1] + c[2];
}

}  // namespace

CLOTHSIM_TARGET_CLONES
void aim_springs(LimitStep step, const Quad* positions, const Quad* velocities,
                 const double* longest, std::size_t count, LimitedSpring* springs) {
  const double back = step.reach * step.h;
  const double share = std::min(violation_rate * step.h, most_of_violation) / (1 + 3 * step.active);
  for (std::size_t i = 0; i < count; ++i) {
    LimitedSpring& s = springs[i];
    // Where the ends were when the step's impulses act: there they make no angular momentum.
    const Vector speed = vector(velocities[s.b]) - vector(velocities[s.a]);
    const Vector d = vector(positions[s.b]) - vector(positions[s.a]) - back * speed;
    const double length = std::sqrt(dot(d, d));
    if (length == 0) {  // slack, and no direction to hold
      s.direction = {0, 0, 0, 0};
      s.impulse = s.fastest = 0;
      continue;
    }
    const Vector direction = d / length;
    vector(s.direction) = direction;

    // How fast it may still lengthen: up to its limit within a step, or shorter if it is over. A
    // spring that turns at speed v across grows by h^2 v^2 / 2 l in a step if it may not lengthen
    // in the middle of it: half its centripetal acceleration v^2 / l over h makes up for that.
    const Vector across = speed - dot(speed, direction) * direction;
    const double excess = length - longest[i];
    const double turning =
        std::min(step.h * dot(across, across) / (2 * length), most_turning * length / step.h);
    s.fastest = (excess > 0 ? share : 1.0) * -excess / step.h - turning;
  }
}

CLOTHSIM_TARGET_CLONES
void pull_points(const LimitedSpring* springs, std::size_t count, Quad* velocities) {
  for (std::size_t i = 0; i < count; ++i) {
    const LimitedSpring& s = springs[i];
    Vector& a = vector(velocities[s.a]);
    Vector& b = vector(velocities[s.b]);
    const Vector direction = vector(s.direction);
    const double a_change = a[3] * s.impulse;
    const double b_change = b[3] * s.impulse;
    a += a_change * direction;
    b -= b_change * direction;
  }
}

CLOTHSIM_TARGET_CLONES
double sweep_springs(LimitedSpring* springs, std::size_t count, Quad* velocities) {
  double largest = 0;
  for (std::size_t i = 0; i < count; ++i) {
    LimitedSpring& s = springs[i];
    Vector& a = vector(velocities[s.a]);
    Vector& b = vector(velocities[s.b]);
    const Vector direction = vector(s.direction);
    const double inv_mass = a[3] + b[3];
    const double rate = dot(direction, b - a);
    const double change = std::max(-s.impulse, (rate - s.fastest) * s.mass);
    s.impulse += change;
    largest = std::max(largest, std::abs(change) * inv_mass);
    const double a_change = a[3] * change;
    const double b_change = b[3] * change;
    a += a_change * direction;
    b -= b_change * direction;
  }
  return largest;
}

CLOTHSIM_TARGET_CLONES
bool any_longer(const LimitedSpring* springs, const double* longest, std::size_t count,
                double share, const Quad* positions) {
  bool any = false;
  for (std::size_t i = 0; i < count; ++i) {
    const LimitedSpring& s = springs[i];
    const Vector d = vector(positions[s.b]) - vector(positions[s.a]);
    const double allowed = share * longest[i];
    any |= dot(d, d) > allowed * allowed;
  }
  return any;
}

CLOTHSIM_TARGET_CLONES
void flag_longer(const double* x, const double* y, const double* z, int offset, int count,
                 double longest2, unsigned char* __restrict flags) {
  for (int i = 0; i < count; ++i) {
    const double dx = x[i + offset] - x[i];
    const double dy = y[i + offset] - y[i];
    const double dz = z[i + offset] - z[i];
    flags[i] = dx * dx + dy * dy + dz * dz > longest2;
  }
}

}  // namespace clothsim
