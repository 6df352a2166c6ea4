// The budget of a frame: a state that was set may be arbitrary, and no frame may hang.

#include <algorithm>
#include <cmath>

#include "simulator_impl.h"

namespace clothsim {
namespace {

/// Visits to each point allowed in a frame from a state that was set, in addition to one for each
/// pass of the substeps that the springs alone need. That is about a second of work for 50 x 50
/// points.
constexpr double visits_a_point = 40e3;

}  // namespace

void Simulator::Impl::allow_work(double dt) {
  // From a state of the simulation itself a frame gets one visit for each pass of all possible
  // substeps. A hit at 100 m/s takes a fifth of that.
  const double visits =
      is_given ? visits_a_point + max_passes * min_substeps(dt) : max_passes * max_substeps;
  budget.allow(cloth.num_points() * visits);
}

double Simulator::Impl::min_substeps(double dt) const {
  if (scene.simulation.substeps) return *scene.simulation.substeps;
  double omega = method->omega_max;
  if (!std::isfinite(omega)) omega = omega_max_bound(cloth, state.positions);
  const double for_springs = dt * omega / method->stability_limit();
  return std::clamp<double>(for_springs, method->choice.min_substeps, max_substeps);
}

}  // namespace clothsim
