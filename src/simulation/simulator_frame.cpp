// A frame: its substeps, and whether it has succeeded.

#include <algorithm>
#include <cmath>
#include <limits>

#include "clothsim/dynamics/spectrum.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/stretch.h"
#include "clothsim/model/errors.h"
#include "clothsim/model/target_clones.h"
#include "simulator_impl.h"

namespace clothsim {
namespace {

const std::vector<MovingCollider> no_colliders;

/// Are all `count` numbers smaller than `farthest`? False for NaN.
CLOTHSIM_TARGET_CLONES
bool are_near(const double* numbers, Eigen::Index count) {
  long outside = 0;
  for (Eigen::Index i = 0; i < count; ++i) outside += !(std::abs(numbers[i]) < farthest);
  return outside == 0;
}

bool is_good(const State& state) {
  return are_near(state.positions.data(), state.positions.size()) &&
         are_near(state.velocities.data(), state.velocities.size());
}

}  // namespace

Outcome Simulator::Impl::frame(bool may_be_apart, const State& before, StepReport& report) {
  const int recoveries = report.recoveries;  // all else is of this try
  report = {};
  report.recoveries = recoveries;
  course = {course.dt};
  course.push = strongest_push();
  course.is_apart = may_be_apart && has_colliders() && is_out_of_reach();
  if (course.is_apart) collider_contacts.reset();
  if (has_air()) {
    const SimulationSpec& spec = scene.simulation;
    course.wind =
        wind_at(spec.wind.value_or(Vector3::Zero()), {spec.gusts, spec.seed}, before.time);
  }
  const int steps = first_substeps();
  report.method = method->choice.method;
  report.predicted_error = method->choice.predicted_error;
  report.reasons = method->choice.reasons;
  const bool is_unstable = scene.simulation.substeps && is_beyond_stability(course.dt / steps);
  if (is_unstable) report.reasons.add(Reason::beyond_stability);
  if (has_colliders() && !course.is_apart) course.stretch = worst_stretch(cloth, state.positions);

  set_out();
  if (!take_substeps(steps, before, report) || !is_good(state)) return Outcome::failed;
  if (course.is_apart && longest_way(before.positions, state.positions) > course.allowed_way) {
    return Outcome::went_too_far;
  }
  report.worst_stretch = worst_stretch(cloth, state.positions);
  tell_reasons(report);
  return is_explained(before, report) ? Outcome::good : Outcome::failed;
}

void Simulator::Impl::set_out() {
  if (!holders.empty()) holders.begin_frame(hold_targets(), course.dt, state);
  if (collider_contacts.is_leaving() && !is_still()) collider_contacts.try_anew();
  if (strain_limit) strain_limit->set_out(speed_given());
  if (weighs_colliders) collider_impulses.assign(colliders.size(), {});
}

double Simulator::Impl::speed_given() const {
  const double by_air = has_air() ? air_speed() : 0;
  return (scene.simulation.gravity.norm() + course.push) * course.dt + course.approach_speed +
         by_air;
}

bool Simulator::Impl::is_still() const {
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (cloth.inv_mass[i] == 0 && !state.velocities.row(i).isZero(0)) return false;
  }
  return !disturbed && std::all_of(colliders.begin(), colliders.end(), [](const MovingCollider& c) {
    return c.velocity().isZero(0) && c.angular_velocity().isZero(0);
  });
}

int Simulator::Impl::first_substeps() {
  const double dt = course.dt;
  course.approach_speed = contact_speed();
  int least = substeps_at_speed(cloth, course.approach_speed, dt);
  course.is_fast = least > 1;
  if (follows_tension()) {
    least = substeps_under_tension(dt, least);
    if (!collider_contacts.recovers()) least = std::max(least, substeps_for_parting(dt));
  }
  if (has_air()) {
    // Air takes no more than all of the velocity against it in a substep.
    const double rate = air_rate(cloth, scene.cloth.material.drag, air_speed());
    const double steps = std::min(std::ceil(dt * rate), double{max_substeps});
    least = std::max(least, static_cast<int>(steps));
  }
  course.motion_step = dt / least;
  return method->substeps(scene.simulation, cloth, state.positions, least, workers);
}

bool Simulator::Impl::take_substeps(int steps, const State& before, StepReport& report) {
  int held_back = 0;
  for (double h = course.dt / steps; steps > 0; --steps, ++report.substeps) {
    // More and shorter ones where tension has come, or layers went too far for their contacts.
    course.left = h * steps;
    const bool looks_again =
        report.substeps > 0 && follows_tension() && !collider_contacts.recovers();
    int needed = looks_again ? substeps_under_tension(course.left, steps) : steps;
    if (report.held_back > held_back && outruns_contacts(h, report)) {
      needed = std::max(needed, std::min(2 * steps, max_substeps));
    }
    held_back = report.held_back;
    if (needed > steps) {
      course.motion_step = h = course.left / (steps = needed);
      course.served = 0;
    }
    if (is_interrupted && is_interrupted()) {
      throw Interrupted("interrupted in the frame after t = " + std::to_string(before.time) + " s");
    }
    if (!substep(h, report)) return false;
  }
  return true;
}

bool Simulator::Impl::outruns_contacts(double h, const StepReport& report) const {
  return !scene.simulation.substeps && report.pinched == 0 &&
         longest_row(state.velocities) * h > cloth.thickness;
}

void Simulator::Impl::tell_reasons(StepReport& report) const {
  if (report.ran_out > 0) {
    report.reasons.add(Reason::newton_ran_out, "in " + std::to_string(report.ran_out) + " of " +
                                                   std::to_string(report.substeps) + " substeps");
  }
  if (course.gives_way) report.reasons.add(Reason::limit_yields);
  if (course.repairs_ran_out ||
      (strain_limit && strain_limit->is_beyond_repair(report.worst_stretch))) {
    report.reasons.add(Reason::passes_ran_out);
  }
}

bool Simulator::Impl::is_explained(const State& before, const StepReport& report) {
  // A limit that gives way pulls with more than a step can carry: no fault of the method, but for
  // speeds that no pull explains.
  const bool may_be_pulled = course.gives_way && !report.reasons.has(Reason::beyond_stability) &&
                             longest_row(state.velocities) < fastest_given;
  if (disturbed || may_be_pulled) {
    energy_watch.restart();
    return true;
  }
  return energy_watch.accepts(cloth, scene.simulation.gravity, course.dt, before, state, colliders,
                              course.recovers ? recovery_speed : 0, course.wind.norm(),
                              work_of_pushes(course.dt, before) + holders.work());
}

bool Simulator::Impl::is_beyond_stability(double h) const {
  const double limit = method->stability_limit();
  if (h * method->omega_max < limit) return false;  // by far the cheaper bound
  return h * omega_max_bound(cloth, state.positions) > limit;
}

bool Simulator::Impl::follows_tension() const {
  // Implicit methods keep to one step: to change it costs them a factorisation or their history.
  return strain_limit && !scene.simulation.substeps && std::isfinite(method->stability_limit());
}

int Simulator::Impl::substeps_under_tension(double dt, int least) const {
  const Vector3& gravity = scene.simulation.gravity;
  // What is being pushed out of a collider is no tension: as many as follow the whole weight.
  if (collider_contacts.recovers()) {
    return std::max(least, substeps_at_weight(cloth, gravity, dt));
  }
  const TensionInertia& inertia = strain_limit->inertia();
  if (touches()) {
    const bool is_smooth =
        !self_contacts && !holders.any_slips() && !collider_contacts.has_edges(colliders, cloth);
    return substeps_at_tension(cloth, strongest_pull(), inertia.frequency(cloth), dt, least,
                               is_smooth);
  }
  return substeps_at_share(cloth, gravity, inertia.share(dt), dt, least);
}

double Simulator::Impl::strongest_pull() const {
  const double weight = cloth.mass.sum() * scene.simulation.gravity.norm();
  return holders.any_slips() ? std::max(weight, holders.strongest()) : weight;
}

int Simulator::Impl::substeps_for_parting(double dt) const {
  return substeps_at_parting(cloth, state.velocities, dt, method->choice.least_substeps);
}

bool Simulator::Impl::is_out_of_reach() {
  const Eigen::AlignedBox3d box(state.positions.colwise().minCoeff().transpose(),
                                state.positions.colwise().maxCoeff().transpose());
  // What pins and springs do beside what it does by itself, hardly ever is as much and an edge
  // more.
  const double edge = shortest_rest_length(cloth);
  const double pull = scene.simulation.gravity.norm() + course.push;
  const double own = longest_row(state.velocities) + pull * course.dt;
  course.allowed_way = 2 * own * course.dt + edge;
  // Contact begins that much before the surfaces meet.
  const double apart = edge + cloth.thickness;
  return std::none_of(colliders.begin(), colliders.end(), [&](const MovingCollider& collider) {
    return collider.reaches(box, apart + course.allowed_way + collider.fastest_in(box) * course.dt);
  });
}

double Simulator::Impl::contact_speed() const {
  if (!touches()) return 0;
  const double own = longest_row(state.velocities);
  Eigen::AlignedBox3d box(state.positions.colwise().minCoeff().transpose(),
                          state.positions.colwise().maxCoeff().transpose());
  const double pull = scene.simulation.gravity.norm() + course.push;
  const double fall = pull * course.dt / 2;  // of the frame itself
  double fastest = 0;
  for (const MovingCollider& collider : colliders) {
    const double speed = own + collider.fastest_in(box);
    if (collider.reaches(box, (speed + fall) * course.dt)) fastest = std::max(fastest, speed);
  }
  return fastest;
}

const Cloth& Simulator::Impl::weigh(double h) {
  // Implicit methods hold tension by themselves. Where contact passes impacts on, steps follow it:
  // with inertia piles that are hit keep knots.
  if (!strain_limit || touches() || !std::isfinite(method->stability_limit())) return cloth;
  strain_limit->inertia().weigh(cloth, h, state, weighed.inv_mass);
  return weighed;
}

bool Simulator::Impl::substep(double h, StepReport& report) {
  course.h = h;
  if (touches()) {
    for (MovingCollider& collider : colliders) collider.advance(h);
    start = state.positions;
    start_velocities = state.velocities;
    if (self_contacts && course.served > 0 && course.since == 0) sought_at = start;
    course.since += h;
  }
  if (!holders.empty()) {
    impulses.resize(cloth.num_points(), 3);
    holders.clear_rows(impulses);
    const bool seen = !course.is_apart && has_colliders();
    if (holders.begin_substep(h, cloth, seen ? colliders : no_colliders, state.positions)) {
      follow_holders();
    }
  }

  if (has_air()) blow(h);
  const Loads loads{scene.simulation.gravity, !touches_others() && is_free()};
  const Cloth& inert = weigh(h);
  if (&inert == &weighed) {
    report.added_mass = std::max(report.added_mass, strain_limit->inertia().share(h));
  }
  // Half of the pushes before and half after: a point that nothing else acts on moves as it must.
  push(inert, h / 2);
  std::visit([&](auto& m) { m.step(inert, loads, h, state, workers); }, method->integrator);
  push(inert, h / 2);
  last_substep = h;
  report.ran_out += std::visit([](const auto& m) { return m.ran_out(); }, method->integrator);
  spend(1);

  if (touches() && course.served == 0 && !is_good(state)) return false;  // numbers to sort by
  if (strain_limit || touches()) constrain(inert, h, report);
  if (!holders.empty()) judge_holders(h);
  if (weighs_colliders) add_collider_impulses(h);
  return !budget.is_spent();
}

double Simulator::Impl::stretch_after(double h) const {
  if (course.approach_speed == 0) return course.stretch;
  const bool is_kept = strain_limit && substeps_at_speed(cloth, course.approach_speed, h) == 1;
  if (is_kept) return course.stretch;  // the limit takes back what so little parts
  const double so_far = course.is_fast ? worst_stretch(cloth, state.positions) : course.stretch;
  return so_far + course.approach_speed * h / shortest_rest_length(cloth);
}

void Simulator::Impl::blow(double h) {
  const Points& forces = air.compute(cloth, scene.cloth.material.drag, course.wind, state, workers);
  state.velocities += h * (forces.array().colwise() * cloth.inv_mass.array()).matrix();
  if (!holders.empty()) impulses += h * forces;
}

}  // namespace clothsim
