#include "clothsim/simulation/substeps.h"

#include <algorithm>
#include <cmath>

#include "clothsim/dynamics/spectrum.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/simulation/scene.h"

namespace clothsim {
namespace {

/// Share of the stability limit used: springs may stretch within a frame.
constexpr double spring_margin = 0.8;

/// Largest h omega across springs under tension. Here the limit's sweeps, not stability, set the
/// step, whatever the method: at half of Verlet's limit the directions of the springs hold through
/// a step and a few sweeps do; nearer to it they turn so far that hundreds do not.
constexpr double tension_limit = 1;

/// Way of a collider in a substep, of the shortest spring. At 0.5 a sphere at 10 m/s already
/// carries points off through the cloth.
constexpr double way_share = 0.25;

/// Frequency [rad/s] across the springs of a point that carry the whole cloth's weight, as the
/// strain limit can make them near a pin: omega^2 = T / (m l).
double tension_frequency(const Cloth& cloth, const Vector3& gravity) {
  return std::sqrt(cloth.mass.sum() * gravity.norm() * cloth.inv_mass.maxCoeff() /
                   shortest_rest_length(cloth));
}

}  // namespace

int count_substeps(const Cloth& cloth, const Vector3& gravity, const Points& positions,
                   double stability_limit, double dt) {
  double steps = 1;
  if (cloth.strain_limit) steps = dt * tension_frequency(cloth, gravity) / tension_limit;

  // The springs, by the cheap bound first.
  const auto for_springs = [&](double omega) {
    return dt * omega / (spring_margin * stability_limit);
  };
  if (for_springs(omega_max_bound(cloth)) > steps) {
    steps = std::max(steps, for_springs(omega_max_bound(cloth, positions)));
  }
  return static_cast<int>(std::clamp(std::ceil(steps), 1.0, double{max_substeps}));
}

int substeps_at_speed(const Cloth& cloth, double speed, double dt) {
  const double steps = dt * speed / (way_share * shortest_rest_length(cloth));
  return static_cast<int>(std::clamp(std::ceil(steps), 1.0, double{max_substeps}));
}

}  // namespace clothsim
