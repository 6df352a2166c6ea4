#include "clothsim/simulation/substeps.h"

#include <algorithm>
#include <cmath>

#include "clothsim/dynamics/spectrum.h"

namespace clothsim {
namespace {

/// Share of the stability limit used: springs may stretch within a frame.
constexpr double spring_margin = 0.8;

/// Share used for strings under tension; the limit's sweeps, not the step's stability, set it:
/// at 0.4 pinned2 needs one sweep a substep, at 0.8 a hundred.
constexpr double tension_margin = 0.4;

/// Frequency [rad/s] of a point between springs that carry the whole cloth's weight, shared by the
/// pins: omega^2 = T / (m l), where the strain limit may put that much tension.
double tension_frequency(const Cloth& cloth, const Vector3& gravity) {
  const double supports = std::max<double>(1, static_cast<double>(cloth.pinned.size()));
  double inv_mass_length = 0;
  for (const SpringRun& run : cloth.springs) {
    inv_mass_length = std::max(inv_mass_length, 1 / run.rest_length);
  }
  inv_mass_length *= cloth.inv_mass.maxCoeff();
  return std::sqrt(cloth.mass.sum() * gravity.norm() / supports * inv_mass_length);
}

}  // namespace

int count_substeps(const Cloth& cloth, const Vector3& gravity, const Points& positions,
                   double stability_limit, double dt) {
  double steps = dt * omega_max_bound(cloth, positions) / (spring_margin * stability_limit);
  if (cloth.strain_limit) {
    steps = std::max(steps,
                     dt * tension_frequency(cloth, gravity) / (tension_margin * stability_limit));
  }
  return std::max(1, static_cast<int>(std::ceil(steps)));
}

}  // namespace clothsim
