// What a frame may cost: a state that was set may be anything, and no frame may hang.

#include <algorithm>

#include "simulator_impl.h"

namespace clothsim {
namespace {

/// Visits that a frame may take for each point from a state that was set, beside one in each pass
/// of the substeps that the springs alone need. 50 x 50 points get a second.
constexpr double visits_a_point = 40e3;

}  // namespace

void Simulator::Impl::allow_work(double dt) {
  // From a state that the simulation came to, one in each pass of all substeps that there may be:
  // what is hit at 100 m/s takes a fifth of it.
  const double visits =
      is_given ? visits_a_point + max_passes * min_substeps(dt) : max_passes * max_substeps;
  budget.allow(cloth.num_points() * visits);
}

double Simulator::Impl::min_substeps(double dt) const {
  if (scene.simulation.substeps) return *scene.simulation.substeps;
  const double for_springs = dt * method->omega_max / method->stability_limit();
  return std::clamp<double>(for_springs, method->choice.min_substeps, max_substeps);
}

}  // namespace clothsim
