// What a frame may cost: a state that was set may be anything, and no frame may hang.

#include <algorithm>
#include <cmath>

#include "simulator_impl.h"

namespace clothsim {
namespace {

/// Visits that a frame may take for each point from a state that was set: some, and more for each
/// substep that the springs alone need. 50 x 50 points get a second.
constexpr double visits_a_point = 40e3;
constexpr double visits_a_substep = 400;

/// Newton steps of a substep that are usual, and what one takes: a sparse factorisation, of so many
/// visits for each point and each along a side (25 x 25 to 100 x 100 points measured).
constexpr double usual_newton_steps = 3;
constexpr double visits_of_factorisation = 40;

/// So many times that from a state that the simulation came to: what is hit at 100 m/s takes ten.
constexpr double patience = 100;

}  // namespace

void Simulator::Impl::allow_work(double dt) {
  const bool is_implicit = std::holds_alternative<ImplicitEuler>(method->integrator) ||
                           std::holds_alternative<Bdf2>(method->integrator);
  const double a_substep =
      visits_a_substep + (is_implicit ? usual_newton_steps * visits_of_newton_step() : 0);
  const double visits = visits_a_point + a_substep * least_substeps(dt);
  budget.allow(cloth.num_points() * visits * (is_given ? 1 : patience));
}

double Simulator::Impl::visits_of_newton_step() const {
  return visits_of_factorisation * std::sqrt(cloth.num_points());
}

double Simulator::Impl::least_substeps(double dt) const {
  if (scene.simulation.substeps) return *scene.simulation.substeps;
  const double for_springs = dt * method->omega_max / method->stability_limit();
  return std::clamp<double>(for_springs, method->choice.least_substeps, max_substeps);
}

}  // namespace clothsim
