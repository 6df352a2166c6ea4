// A frame: its substeps, and whether it has succeeded.

#include <algorithm>
#include <cmath>

#include "clothsim/constraints/least_distance.h"
#include "clothsim/dynamics/spectrum.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/stretch.h"
#include "clothsim/model/errors.h"
#include "clothsim/model/target_clones.h"
#include "simulator_impl.h"

namespace clothsim {
namespace {

const std::vector<MovingCollider> no_colliders;

/// Speed at which a fabric that starts nearer to a collider than its thickness is lifted [m/s]. At
/// once, the points on top of a round shape would stretch their springs and be thrown.
constexpr double growth_of_offset = 0.1;

/// Are all `count` numbers smaller than `farthest`? False for NaN.
CLOTHSIM_TARGET_CLONES
bool are_near(const double* numbers, Eigen::Index count) {
  long outside = 0;
  for (Eigen::Index i = 0; i < count; ++i) outside += !(std::abs(numbers[i]) < farthest);
  return outside == 0;
}

/// Do lagged impulses of contact act in the steps of a method? Not in those of BDF2, whose history
/// would keep them.
bool takes_lagged_contact(const Integrator& integrator) {
  return std::holds_alternative<Xpbd>(integrator) ||
         std::holds_alternative<ImplicitEuler>(integrator);
}

bool is_good(const State& state) {
  return are_near(state.positions.data(), state.positions.size()) &&
         are_near(state.velocities.data(), state.velocities.size());
}

}  // namespace

Outcome Simulator::Impl::frame(bool may_be_apart, const State& before, StepReport& report) {
  const int recoveries = report.recoveries;  // all other numbers are of this try
  report = {};
  report.recoveries = recoveries;
  frame_context = {frame_context.dt};
  frame_context.external_acceleration = max_external_acceleration();
  frame_context.is_apart = may_be_apart && has_colliders() && is_out_of_reach();
  if (frame_context.is_apart) collider_contacts.reset();
  if (has_air()) {
    const SimulationSpec& spec = scene.simulation;
    frame_context.wind =
        wind_at(spec.wind.value_or(Vector3::Zero()), {spec.gusts, spec.seed}, before.time);
  }
  const int steps = first_substeps();
  report.method = method->choice.method;
  report.predicted_error = method->choice.predicted_error;
  report.reasons = method->choice.reasons;
  const bool is_unstable =
      scene.simulation.substeps && is_beyond_stability(frame_context.dt / steps);
  if (is_unstable) report.reasons.add(Reason::beyond_stability);
  if (has_colliders() && !frame_context.is_apart) {
    frame_context.stretch = worst_stretch(cloth, state.positions);
  }

  frame_context.lifts = cloth.offset < cloth.full_offset;
  begin_frame();
  if (!take_substeps(steps, before, report) || !is_good(state) || !has_good_bodies()) {
    return Outcome::failed;
  }
  if (frame_context.is_apart && longest_displacement(before.positions, state.positions) >
                                    frame_context.allowed_displacement) {
    return Outcome::went_too_far;
  }
  report.worst_stretch = worst_stretch(cloth, state.positions);
  report.violation = worst_violation(cloth, state.positions, report.worst_stretch);
  tell_reasons(report);
  return is_explained(before, report) ? Outcome::good : Outcome::failed;
}

void Simulator::Impl::begin_offset() {
  knows_offset = true;
  cloth.offset = cloth.full_offset;
  if (cloth.full_offset == surface_offset) return;
  cloth.offset = std::max(surface_offset, least_distance(colliders, cloth, state.positions));
}

void Simulator::Impl::begin_frame() {
  if (!holders.empty()) holders.begin_frame(hold_targets(), frame_context.dt, state);
  attachments.begin_frame();
  // Something moves again: colliders push cloth out at full speed.
  if (collider_contacts.has_recovered_recently() && !is_still()) collider_contacts.reset_recovery();
  if (strain_limit) strain_limit->begin_frame(speed_given());
  if (measures_wrenches) collider_impulses.assign(colliders.size(), {});
}

double Simulator::Impl::speed_given() const {
  const double by_air = has_air() ? air_speed() : 0;
  return (scene.simulation.gravity.norm() + frame_context.external_acceleration) *
             frame_context.dt +
         frame_context.approach_speed + by_air;
}

bool Simulator::Impl::is_still() const {
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (cloth.inv_mass[i] == 0 && !state.velocities.row(i).isZero(0)) return false;
  }
  if (disturbed) return false;
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    const MovingCollider& c = colliders[k];
    const bool is_moved = !c.velocity().isZero(0) || !c.angular_velocity().isZero(0);
    if (is_moved && !bodies.is_body(k)) return false;
  }
  return true;
}

int Simulator::Impl::first_substeps() {
  const double dt = frame_context.dt;
  frame_context.approach_speed = contact_speed();
  int min_steps = substeps_at_speed(cloth, frame_context.approach_speed, dt);
  frame_context.is_fast = min_steps > 1;
  if (follows_tension()) {
    min_steps = substeps_under_tension(dt, min_steps);
    if (!collider_contacts.recovers()) {
      min_steps = substeps_at_parting(cloth, state.velocities, dt, min_steps);
    }
  }
  if (has_air()) {
    // Air removes at most all of the relative velocity in a substep.
    const double rate = air_rate(cloth, air_speed());
    const double steps = std::min(std::ceil(dt * rate), double{max_substeps});
    min_steps = std::max(min_steps, static_cast<int>(steps));
  }
  if (!bodies.empty()) min_steps = std::max(min_steps, substeps_of_bodies(dt));
  frame_context.motion_step = dt / min_steps;
  return method->substeps(scene.simulation, cloth, state.positions, min_steps, workers);
}

bool Simulator::Impl::take_substeps(int steps, const State& before, StepReport& report) {
  int truncated = 0;
  for (double h = frame_context.dt / steps; steps > 0; --steps, ++report.substeps) {
    // Shorten the remaining substeps if tension has risen, or if the guard truncated points and
    // layers move farther than their thickness in one.
    frame_context.left = h * steps;
    const bool looks_again =
        report.substeps > 0 && follows_tension() && !collider_contacts.recovers();
    int needed = looks_again ? substeps_under_tension(frame_context.left, steps) : steps;
    if (report.held_back > truncated && outruns_contacts(h, report)) {
      needed = std::max(needed, std::min(2 * steps, max_substeps));
    }
    truncated = report.held_back;
    if (needed > steps) {
      frame_context.motion_step = h = frame_context.left / (steps = needed);
      frame_context.steps_left = 0;  // so that the next substep runs detection
    }
    if (is_interrupted && is_interrupted()) {
      throw Interrupted("interrupted in the frame after t = " + std::to_string(before.time) + " s");
    }
    cloth.offset = std::min(cloth.full_offset, cloth.offset + growth_of_offset * h);
    if (!substep(h, report)) return false;
  }
  return true;
}

bool Simulator::Impl::outruns_contacts(double h, const StepReport& report) const {
  return !scene.simulation.substeps && report.pinched == 0 &&
         longest_row(state.velocities) * h > cloth.min_thickness();
}

void Simulator::Impl::tell_reasons(StepReport& report) const {
  if (report.ran_out > 0) {
    report.reasons.add(Reason::newton_unconverged, "in " + std::to_string(report.ran_out) + " of " +
                                                       std::to_string(report.substeps) +
                                                       " substeps");
  }
  if (frame_context.yields) report.reasons.add(Reason::limit_yields);
  if (frame_context.projection_unconverged ||
      (strain_limit && strain_limit->is_beyond_repair(report.violation))) {
    report.reasons.add(Reason::passes_unconverged);
  }
}

bool Simulator::Impl::is_explained(const State& before, const StepReport& report) {
  // Where the strain limit yields, energy may grow without a failure of the method. Then a frame
  // fails only at speeds from max_given_speed on.
  const bool may_be_pulled = frame_context.yields &&
                             !report.reasons.has(Reason::beyond_stability) &&
                             longest_row(state.velocities) < max_given_speed;
  if (disturbed || may_be_pulled) {
    energy_watch.restart();
    return true;
  }
  const double lift_speed = frame_context.lifts ? growth_of_offset : 0;
  return energy_watch.accepts(
      cloth, scene.simulation.gravity, frame_context.dt, before, state, colliders,
      frame_context.recovers ? recovery_speed : lift_speed, frame_context.wind.norm(),
      work_of_external_forces(frame_context.dt, before) + holders.work() + attachments.work());
}

bool Simulator::Impl::is_beyond_stability(double h) const {
  const double limit = method->stability_limit();
  if (h * method->omega_max < limit || !std::isfinite(limit)) return false;
  return omega_max_bound(cloth, state.positions, limit / h, workers) > limit / h;
}

bool Simulator::Impl::follows_tension() const {
  // Implicit methods keep one step: a change costs bdf2 its history.
  return strain_limit && !scene.simulation.substeps && std::isfinite(method->stability_limit());
}

int Simulator::Impl::substeps_under_tension(double dt, int min_steps) const {
  const Vector3& gravity = scene.simulation.gravity;
  // While colliders push cloth out, the impulses of the limit do not measure tension: take the
  // substeps for a tension of the whole weight.
  if (collider_contacts.recovers()) {
    return std::max(min_steps, substeps_at_weight(cloth, gravity, dt));
  }
  const TensionInertia& inertia = strain_limit->inertia();
  if (touches()) {
    const bool is_smooth =
        !self_contacts && !holders.any_slips() && !collider_contacts.has_edges(colliders, cloth);
    const double on_bodies = bodies.mass() * gravity.norm();
    const double pull =
        std::max(holders.any_slips() ? holders.strongest() : 0,
                 bodies.empty() ? 0 : cloth.mass.sum() * gravity.norm() + on_bodies);
    return substeps_at_tension(cloth, gravity, inertia.frequency(cloth), dt, min_steps, is_smooth,
                               pull);
  }
  return substeps_at_mass_ratio(cloth, gravity, inertia.mass_ratio(dt), dt, min_steps);
}

bool Simulator::Impl::is_out_of_reach() {
  const Eigen::AlignedBox3d box(state.positions.colwise().minCoeff().transpose(),
                                state.positions.colwise().maxCoeff().transpose());
  // Largest displacement of a point in this frame, as expected: twice the one by its speed and the
  // external forces, plus the length of the shortest spring for pins and springs. A frame with a
  // larger one is repeated with contact.
  const double edge = shortest_rest_length(cloth);
  const double pull = scene.simulation.gravity.norm() + frame_context.external_acceleration;
  const double own = longest_row(state.velocities) + pull * frame_context.dt;
  frame_context.allowed_displacement = 2 * own * frame_context.dt + edge;
  // Contact begins at this distance of the surfaces.
  const double apart = edge + cloth.thickness;
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    const MovingCollider& collider = colliders[k];
    const double of_surface = bodies.is_body(k) ? displacement_of_bodies(frame_context.dt)
                                                : collider.max_speed_in(box) * frame_context.dt;
    if (collider.reaches(box, apart + frame_context.allowed_displacement + of_surface))
      return false;
  }
  return true;
}

double Simulator::Impl::contact_speed() const {
  if (!touches()) return 0;
  const double own = longest_row(state.velocities);
  Eigen::AlignedBox3d box(state.positions.colwise().minCoeff().transpose(),
                          state.positions.colwise().maxCoeff().transpose());
  const double pull = scene.simulation.gravity.norm() + frame_context.external_acceleration;
  const double fall = pull * frame_context.dt / 2;  // in the frame itself
  double max_speed = 0;
  for (const MovingCollider& collider : colliders) {
    const double speed = own + collider.max_speed_in(box);
    if (collider.reaches(box, (speed + fall) * frame_context.dt)) {
      max_speed = std::max(max_speed, speed);
    }
  }
  return max_speed;
}

const Cloth& Simulator::Impl::add_tension_mass(double h) {
  // Implicit methods need no added inertia: they are stable under tension. In contact substeps get
  // shorter instead: with added inertia, piles that are hit keep knots.
  if (!strain_limit || touches() || !std::isfinite(method->stability_limit())) return cloth;
  strain_limit->inertia().add_tension_mass(cloth, h, state, cloth_with_tension_mass.inv_mass,
                                           workers);
  return cloth_with_tension_mass;
}

bool Simulator::Impl::substep(double h, StepReport& report) {
  frame_context.h = h;
  if (touches() || !bodies.empty()) {
    for (std::size_t k = 0; k < colliders.size(); ++k) {
      if (!bodies.is_body(k)) colliders[k].advance(h);
    }
  }
  if (!bodies.empty()) begin_bodies(h);
  if (touches()) {
    start = state.positions;
    start_velocities = state.velocities;
    if (self_contacts && frame_context.steps_left > 0 && frame_context.since == 0) {
      detected_at = start;
    }
    frame_context.since += h;
  }
  if (!holders.empty()) {
    impulses.resize(cloth.num_points(), 3);
    holders.clear_rows(impulses);
    const bool seen = !frame_context.is_apart && has_colliders();
    if (holders.begin_substep(h, cloth, seen ? colliders : no_colliders, state.positions)) {
      follow_holders();
    }
  }

  if (has_air()) apply_wind(h);
  // A cloth without pins, grips and colliders in reach falls exactly.
  const Loads loads{scene.simulation.gravity, !touches_others() && is_free(),
                    begin_lagged_contact(h)};
  const Cloth& inert = add_tension_mass(h);
  if (&inert == &cloth_with_tension_mass) {
    report.added_mass = std::max(report.added_mass, strain_limit->inertia().mass_ratio(h));
  }
  // Half of the external forces before and half after: a point without other forces moves exactly.
  apply_external_forces(inert, h / 2);
  std::visit([&](auto& m) { m.step(inert, loads, h, state, workers); }, method->integrator);
  apply_external_forces(inert, h / 2);
  last_substep = h;
  report.ran_out += std::visit([](const auto& m) { return m.unconverged(); }, method->integrator);
  spend(1);

  if (touches() && frame_context.steps_left == 0 && !is_good(state)) {
    return false;  // detection sorts positions, which must be finite for that
  }
  if (strain_limit || touches()) constrain(inert, h, report);
  if (!bodies.empty() && !touches()) solve_bodies_alone();
  if (!holders.empty() || !attachments.empty()) update_holders(h);
  if (measures_wrenches) add_collider_impulses(h);
  return !budget.is_spent();
}

const Points* Simulator::Impl::begin_lagged_contact(double h) {
  frame_context.lags = touches() && takes_lagged_contact(method->integrator);
  if (frame_context.lags) return &lagged_contact.begin_step(h, cloth);
  lagged_contact.reset();
  return nullptr;
}

double Simulator::Impl::stretch_after(double h) const {
  if (frame_context.approach_speed == 0) return frame_context.stretch;
  const bool is_kept =
      strain_limit && substeps_at_speed(cloth, frame_context.approach_speed, h) == 1;
  if (is_kept) return frame_context.stretch;  // the limit corrects the small elongation
  const double so_far =
      frame_context.is_fast ? worst_stretch(cloth, state.positions) : frame_context.stretch;
  return so_far + frame_context.approach_speed * h / shortest_rest_length(cloth);
}

void Simulator::Impl::apply_wind(double h) {
  const Points& forces = air.compute(cloth, frame_context.wind, state, workers);
  state.velocities += h * (forces.array().colwise() * cloth.inv_mass.array()).matrix();
  if (!holders.empty()) impulses += h * forces;
}

}  // namespace clothsim
