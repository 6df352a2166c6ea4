#include "clothsim/constraints/tension_inertia.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "clothsim/dynamics/drag.h"
#include "clothsim/model/lanes.h"
#include "clothsim/model/point_run.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// Added inertia, as a multiple of h^2 sum(T / l). More keeps longer steps stable than the weight
/// needs, but passes converge more slowly with unequal masses: at 0.5 a cloth of 50 x 50 points may
/// shake for lack of passes.
constexpr double inertia_factor = 0.4;

/// Share of added inertia that is left after a step where tension falls. Passes that end early
/// leave noise in tension, and inertia that followed it would make the noise of the next step: at
/// 0.9 the same cloth may shake for ever.
constexpr double kept_share = 0.97;

/// Largest added inertia over a point's mass: with more, no step is stable. With x = h^2 sum(T / l)
/// / m that is x < 2 (1 + inertia_factor x). Where pins or colliders conflict, tension has no
/// bound.
constexpr double max_added = inertia_factor / (0.5 - inertia_factor);

/// Points that are checked together for tension, as the division takes longer than the check.
constexpr int checked_together = num_lanes * num_lanes;

/// Sets inverse masses with the added inertia time2 * stiffness, for free points. Drops stiffness
/// beyond the largest, below the rounding of a mass, or at held points.
CLOTHSIM_TARGET_CLONES
void add_inertia(int count, double time2, const double* mass, const double* without,
                 double* stiffness, double* inv_mass) {
  const double to_stiffness = 1 / time2;
  for (int first = 0; first < count; first += checked_together) {
    const int end = std::min(first + checked_together, count);
    long tense = 0;
    for (int i = first; i < end; ++i) tense += stiffness[i] > 0;
    if (tense == 0) {
      for (int i = first; i < end; ++i) inv_mass[i] = without[i];
      continue;
    }
    for_each_lane(end - first, [&](int lane) CLOTHSIM_INLINE {
      const int i = first + lane;
      const double more = time2 * stiffness[i];
      const double largest = max_added * mass[i];
      const double all = mass[i] + (more < largest ? more : largest);
      const bool counts = (without[i] > 0) & (all > mass[i]);
      const double bounded = more < largest ? stiffness[i] : largest * to_stiffness;
      stiffness[i] = counts ? bounded : 0;
      inv_mass[i] = counts ? 1 / all : without[i];
    });
  }
}

CLOTHSIM_TARGET_CLONES
double total(int count, const double* numbers) {
  Half sums[2] = {};
  int i = 0;
  for (; i + num_lanes <= count; i += num_lanes) {
    for (int half = 0; half < 2; ++half) sums[half] += half_at(numbers + i + half * half_size);
  }
  double sum = 0;
  add_lanes(sums, sum);
  for (; i < count; ++i) sum += numbers[i];
  return sum;
}

CLOTHSIM_TARGET_CLONES
void scale(int count, double factor, double* numbers) {
  for (int i = 0; i < count; ++i) numbers[i] *= factor;
}

CLOTHSIM_TARGET_CLONES
double largest_ratio(int count, const double* numbers, const double* divisors) {
  Half largest[2] = {};
  int i = 0;
  for (; i + num_lanes <= count; i += num_lanes) {
    for (int half = 0; half < 2; ++half) {
      const int k = i + half * half_size;
      const Half ratio = half_at(numbers + k) / half_at(divisors + k);
      largest[half] = ratio > largest[half] ? ratio : largest[half];
    }
  }
  double result = 0;
  take_largest(largest, result);
  for (; i < count; ++i) result = std::max(result, numbers[i] / divisors[i]);
  return result;
}

/// Moments of a cloth as a rigid body, about an origin, and the momentum that added inertia has
/// taken.
struct Body {
  double first[3];   // m x [kg m]
  double second[6];  // m x x, xx yy zz xy yz zx [kg m^2]
  double momentum[3];
  double angular[3];
};

/// The points when the step's impulses acted, and their momentum.
struct Carriers {
  PointRun x;  // at the step's end
  PointRun v;
  PointRun before;  // velocities as the step began
  const double* mass;
  const double* stiffness;
  double impulse_time;  // time back to where impulses acted [s]
  double time2;         // inertia per stiffness [s^2]
  double decay;         // of velocities by drag in the step
  Vector3 origin;
};

CLOTHSIM_TARGET_CLONES
void add_up(int count, const Carriers& c, Body& sums) {
  constexpr int n = sizeof(Body) / sizeof(double);
  double lanes[n][num_lanes] = {};
  const double ox = c.origin.x(), oy = c.origin.y(), oz = c.origin.z();
  for (int first = 0; first < count; first += num_lanes) {
    for_each_lane(std::min(num_lanes, count - first), [&](int lane) CLOTHSIM_INLINE {
      const int i = first + lane;
      const double vx = c.v.x[i], vy = c.v.y[i], vz = c.v.z[i];
      const double x = c.x.x[i] - ox - c.impulse_time * vx;
      const double y = c.x.y[i] - oy - c.impulse_time * vy;
      const double z = c.x.z[i] - oz - c.impulse_time * vz;
      const double m = c.mass[i], more = c.time2 * c.stiffness[i];
      const double px = more * (vx - c.decay * c.before.x[i]);
      const double py = more * (vy - c.decay * c.before.y[i]);
      const double pz = more * (vz - c.decay * c.before.z[i]);
      lanes[0][lane] += m * x;
      lanes[1][lane] += m * y;
      lanes[2][lane] += m * z;
      lanes[3][lane] += m * x * x;
      lanes[4][lane] += m * y * y;
      lanes[5][lane] += m * z * z;
      lanes[6][lane] += m * x * y;
      lanes[7][lane] += m * y * z;
      lanes[8][lane] += m * z * x;
      lanes[9][lane] += px;
      lanes[10][lane] += py;
      lanes[11][lane] += pz;
      lanes[12][lane] += y * pz - z * py;
      lanes[13][lane] += z * px - x * pz;
      lanes[14][lane] += x * py - y * px;
    });
  }
  double* const all = sums.first;
  for (int k = 0; k < n; ++k) {
    double sum = 0;
    for (const double lane : lanes[k]) sum += lane;
    all[k] += sum;
  }
}

/// Adds velocities shift + turn x (middle - origin) to points, and the displacements by these.
CLOTHSIM_TARGET_CLONES
void move_rigidly(int count, const Vector3& shift, const Vector3& turn, const Vector3& origin,
                  double impulse_time, MutablePointRun x, MutablePointRun v) {
  const double wx = turn.x(), wy = turn.y(), wz = turn.z();
  const double sx = shift.x(), sy = shift.y(), sz = shift.z();
  const double ox = origin.x(), oy = origin.y(), oz = origin.z();
  for_each_lane(count, [&](int i) CLOTHSIM_INLINE {
    const double ax = x.x[i] - ox - impulse_time * v.x[i];
    const double ay = x.y[i] - oy - impulse_time * v.y[i];
    const double az = x.z[i] - oz - impulse_time * v.z[i];
    const double gx = sx + wy * az - wz * ay;
    const double gy = sy + wz * ax - wx * az;
    const double gz = sz + wx * ay - wy * ax;
    v.x[i] += gx;
    v.y[i] += gy;
    v.z[i] += gz;
    x.x[i] += impulse_time * gx;
    x.y[i] += impulse_time * gy;
    x.z[i] += impulse_time * gz;
  });
}

}  // namespace

TensionInertia::TensionInertia(const Cloth& cloth)
    : mass_(cloth.mass.sum()), stiffness_(Scalars::Zero(cloth.num_points())) {}

void TensionInertia::add_tension_mass(const Cloth& cloth, double h, const State& state,
                                      Scalars& inv_mass, const Workers& workers) {
  is_free_ = false;
  if (!is_tense_) {
    inv_mass = cloth.inv_mass;
    return;
  }
  inv_mass.resize(cloth.num_points());
  workers.parallel_for(cloth.num_points(), [&](int begin, int end) {
    add_inertia(end - begin, inertia_factor * h * h, &cloth.mass[begin], &cloth.inv_mass[begin],
                &stiffness_[begin], &inv_mass[begin]);
  });
  const double* const first = cloth.inv_mass.data();
  is_free_ = std::all_of(first, first + cloth.num_points(), [](double w) { return w > 0; });
  if (is_free_) start_velocities_ = state.velocities;
}

void TensionInertia::give_back(const Cloth& cloth, double h, double displacement_factor,
                               State& state) {
  if (!is_free_) return;
  is_free_ = false;
  const int count = cloth.num_points();
  const double impulse_time = displacement_factor * h;
  const Vector3 origin = row(state.positions, 0);
  Body body{};
  for_each_damping(cloth, 0, count, [&](int begin, int end, double damping) {
    add_up(end - begin,
           {run_from(state.positions, begin), run_from(state.velocities, begin),
            run_from(start_velocities_, begin), &cloth.mass[begin], &stiffness_[begin],
            impulse_time, inertia_factor * h * h, std::exp(-damping * h), origin},
           body);
  });

  // A rigid motion of the whole, about the centre of mass.
  const Vector3 centre = Vector3(body.first[0], body.first[1], body.first[2]) / mass_;
  const Vector3 momentum(body.momentum[0], body.momentum[1], body.momentum[2]);
  const Vector3 angular =
      Vector3(body.angular[0], body.angular[1], body.angular[2]) - centre.cross(momentum);
  Eigen::Matrix3d spread;
  spread << body.second[0], body.second[3], body.second[5],  //
      body.second[3], body.second[1], body.second[4],        //
      body.second[5], body.second[4], body.second[2];
  spread -= mass_ * centre * centre.transpose();
  const Eigen::Matrix3d inertia = spread.trace() * Eigen::Matrix3d::Identity() - spread;
  const Vector3 turn = inertia.completeOrthogonalDecomposition().solve(angular);
  move_rigidly(count, momentum / mass_, turn, origin + centre, impulse_time,
               run_from(state.positions, 0), run_from(state.velocities, 0));
}

double TensionInertia::mass_ratio(double h) const {
  return is_tense_ ? inertia_factor * h * h * total(count(), stiffness_.data()) / mass_ : 0;
}

double TensionInertia::mass_ratio_at(double frequency, double h) {
  return inertia_factor * (h * frequency) * (h * frequency);
}

double TensionInertia::frequency(const Cloth& cloth) const {
  return is_tense_ ? std::sqrt(largest_ratio(count(), stiffness_.data(), cloth.mass.data())) : 0;
}

void TensionInertia::fade() {
  if (!is_tense_) return;
  scale(count(), kept_share, stiffness_.data());
}

void TensionInertia::add(int point, double stiffness) {
  if (stiffness == 0) return;
  is_tense_ = true;
  stiffness_[point] = std::max(stiffness_[point], stiffness);
}

void TensionInertia::reset() {
  stiffness_.setZero();
  is_tense_ = is_free_ = false;
}

void TensionInertia::take_over(TensionInertia&& last) {
  const double mass = mass_;
  *this = std::move(last);
  mass_ = mass;
}

void TensionInertia::write(MemoryWriter& memory) const {
  memory.add(static_cast<double>((stiffness_.array() > 0).count()));
  for (int i = 0; i < stiffness_.size(); ++i) {
    if (stiffness_[i] == 0) continue;
    memory.add(i);
    memory.add(stiffness_[i]);
  }
}

void TensionInertia::read(MemoryReader& memory) {
  reset();
  for (std::size_t left = memory.count(); left > 0; --left) {
    const int point = memory.index(static_cast<std::size_t>(stiffness_.size()));
    add(point, std::max(0.0, memory.number()));
  }
}

}  // namespace clothsim
