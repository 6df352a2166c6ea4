#include "clothsim/simulation/substeps.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "clothsim/dynamics/spectrum.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/stretch.h"
#include "clothsim/simulation/scene.h"

namespace clothsim {
namespace {

/// Share of the stability limit used: springs may stretch within a frame.
constexpr double spring_margin = 0.85;

/// How tension sets the step.
struct Limits {
  double h_omega;      // largest across springs under tension
  double least_share;  // of the substeps that the whole weight asks for
  double most_share;
};

/// Here the limit's sweeps, not stability, set the step: at less than two thirds of Verlet's limit
/// the directions of the springs hold through a step and a few sweeps do; nearer to it they turn so
/// far that hundreds do not.
constexpr Limits free_limits{1.2, 0.45, 1};

/// Contact passes impacts on to the springs within a step, so steps are shorter: longer ones never
/// rest on a tip. Where the limit cannot be met, tension grows without end: twice the substeps must
/// do. See docs/experiments.md.
constexpr Limits contact_limits{0.5, 0.7, 2};

/// h omega for the springs of a point that carry the whole cloth's weight.
constexpr double weight_limit = 1;

/// Way of a collider in a substep, of the shortest spring, and of one end of a spring against the
/// other, of its length: half of it already tears points off or leaves too much to repairs (see
/// docs/experiments.md).
constexpr double way_share = 0.25;

/// Of what a straight line of springs can reach; a way with corners reaches further.
constexpr double taut = 0.99;

int whole_steps(double steps) {
  return static_cast<int>(std::clamp(std::ceil(steps), 1.0, double{max_substeps}));
}

}  // namespace

double weight_frequency(const Cloth& cloth, const Vector3& gravity) {
  if (!cloth.strain_limit || cloth.springs.empty()) return 0;
  return std::sqrt(cloth.mass.sum() * gravity.norm() * cloth.inv_mass.maxCoeff() /
                   shortest_rest_length(cloth));
}

int substeps_under_tension(double weight, const Tension& tension, double dt) {
  const Limits& limits = tension.touches ? contact_limits : free_limits;
  const double usual = weight / weight_limit;
  return whole_steps(dt * std::clamp(tension.frequency / limits.h_omega, limits.least_share * usual,
                                     limits.most_share * usual));
}

int count_substeps(const Cloth& cloth, const Vector3& gravity, const Points& positions,
                   double stability_limit, double dt, std::optional<Tension> tension,
                   const Workers& workers) {
  const double weight = weight_frequency(cloth, gravity);
  double steps = tension ? substeps_under_tension(weight, *tension, dt)
                         : whole_steps(dt * weight / weight_limit);

  // The springs, by the cheap bound first.
  const double enough = steps * spring_margin * stability_limit / dt;  // for frequencies up to this
  if (omega_max_bound(cloth) > enough) {
    const double omega = omega_max_bound(cloth, positions, enough, workers);
    if (omega > enough) steps = dt * omega / (spring_margin * stability_limit);
  }
  return whole_steps(steps);
}

int substeps_at_speed(const Cloth& cloth, double speed, double dt) {
  const double steps = dt * speed / (way_share * shortest_rest_length(cloth));
  return whole_steps(steps);
}

int substeps_at_parting(const Cloth& cloth, const Points& velocities, double dt) {
  const double rate = worst_stretch(cloth, velocities) + 1;  // |v_b - v_a| / L0, largest
  return whole_steps(dt * rate / way_share);
}

bool are_pulled_taut(const Cloth& cloth, const Points& positions) {
  // Any way through free cloth begins and ends at held points beside free ones.
  std::set<int> held;
  for_each_spring(cloth, [&](const SpringRun&, int a, int b) {
    if (cloth.inv_mass[a] == 0 && cloth.inv_mass[b] > 0) held.insert(a);
    if (cloth.inv_mass[b] == 0 && cloth.inv_mass[a] > 0) held.insert(b);
  });
  const double reach = taut * (1 + cloth.strain_limit.value());
  for (auto first = held.begin(); first != held.end(); ++first) {
    for (auto second = std::next(first); second != held.end(); ++second) {
      const int a = *first, b = *second;
      const double apart = (positions.row(b) - positions.row(a)).norm();
      const double at_rest = (cloth.rest_positions.row(b) - cloth.rest_positions.row(a)).norm();
      if (apart > reach * at_rest) return true;
    }
  }
  return false;
}

}  // namespace clothsim
