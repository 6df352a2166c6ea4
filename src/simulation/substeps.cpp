#include "clothsim/simulation/substeps.h"

#include <algorithm>
#include <cmath>

#include "clothsim/constraints/tension_inertia.h"
#include "clothsim/dynamics/spectrum.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/stretch.h"
#include "clothsim/scene/scene.h"

namespace clothsim {
namespace {

/// Share of the stability limit used: springs may stretch within a frame.
constexpr double spring_margin = 0.85;

/// h omega for the springs of a point that carry the whole cloth's weight. With added inertia
/// longer steps are stable, too, but then soft and heavy cloth stretches beyond its limit as it
/// falls.
constexpr double weight_limit = 4.4;

/// h omega for the tension of a cloth that may touch something, or whose limit yields. On the tip
/// of a box a cloth trembles for ever at 0.7 and rests at 0.5, on a sphere it rests at 1.4. Between
/// two colliders tension has no bound: the steps that the weight needs at this value must suffice.
constexpr double touching_limit = 0.5;

/// Largest inertia added for tension, over the cloth's mass. A cloth of 50 x 50 or 100 x 100 points
/// that hangs by two corners rests at 0.02 and shakes at 0.05, for lack of passes.
constexpr double max_added_mass = 0.015;

/// Frequency [rad/s] across the springs of a point that carry `pull` [N], as the strain limit can
/// cause near a pin: omega^2 = T / (m l). 0 without a strain limit.
double pull_frequency(const Cloth& cloth, double pull) {
  if (!cloth.strain_limit || cloth.springs.empty()) return 0;
  return std::sqrt(pull * cloth.inv_mass.maxCoeff() / shortest_rest_length(cloth));
}

double weight_frequency(const Cloth& cloth, const Vector3& gravity) {
  return pull_frequency(cloth, cloth.mass.sum() * gravity.norm());
}

int whole_steps(double steps) {
  return static_cast<int>(std::clamp(std::ceil(steps), 1.0, double{max_substeps}));
}

}  // namespace

int count_substeps(const Cloth& cloth, const Vector3& gravity, const Points& positions,
                   double stability_limit, double dt, int min_steps, const Workers& workers,
                   double omega_max) {
  double steps =
      std::max(min_steps, whole_steps(dt * weight_frequency(cloth, gravity) / weight_limit));

  // The springs, by the cheap bound first.
  const double enough = steps * spring_margin * stability_limit / dt;  // for frequencies up to this
  if (omega_max > enough) {
    const double omega = omega_max_bound(cloth, positions, enough, workers);
    if (omega > enough) steps = dt * omega / (spring_margin * stability_limit);
  }
  return whole_steps(steps);
}

int substeps_at_speed(const Cloth& cloth, double speed, double dt) {
  const double steps = dt * speed / (motion_share * shortest_rest_length(cloth));
  return whole_steps(steps);
}

int substeps_at_parting(const Cloth& cloth, const Points& velocities, double dt, int min_steps) {
  const double max_rate = 2 * longest_row(velocities) / shortest_rest_length(cloth);
  if (dt * max_rate <= motion_share * min_steps) return min_steps;  // by far the cheaper check
  const double rate = worst_stretch(cloth, velocities) + 1;         // |v_b - v_a| / L0, largest
  return std::max(min_steps, whole_steps(dt * rate / motion_share));
}

int substeps_at_weight(const Cloth& cloth, const Vector3& gravity, double dt) {
  return whole_steps(dt * weight_frequency(cloth, gravity));
}

int substeps_at_tension(const Cloth& cloth, const Vector3& gravity, double frequency, double dt,
                        int min_steps, bool is_smooth, double pull) {
  const double limit = is_smooth ? 2 * touching_limit : touching_limit;
  if (dt * frequency <= limit * min_steps)
    return min_steps;  // the weight takes a loop over all points
  const double max_frequency =
      std::max(weight_frequency(cloth, gravity), pull_frequency(cloth, pull));
  return std::max(min_steps, whole_steps(dt * (std::min(frequency, max_frequency) / limit)));
}

int substeps_at_mass_ratio(const Cloth& cloth, const Vector3& gravity, double mass_ratio, double dt,
                           int min_steps) {
  if (mass_ratio <= max_added_mass * min_steps * min_steps) {
    return min_steps;  // the weight takes a loop over all points
  }
  const double on_either_side = std::sqrt(2) * weight_frequency(cloth, gravity);
  const double max_ratio = TensionInertia::mass_ratio_at(on_either_side, dt);
  return std::max(min_steps,
                  whole_steps(std::sqrt(std::min(mass_ratio, max_ratio) / max_added_mass)));
}

}  // namespace clothsim
