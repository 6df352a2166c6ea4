#include "clothsim/simulation/simulator.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "clothsim/dynamics/spectrum.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/stretch.h"
#include "clothsim/model/errors.h"
#include "clothsim/model/grid.h"
#include "clothsim/model/target_clones.h"
#include "simulator_impl.h"

namespace clothsim {
namespace {

/// Times the usual substeps that springs which part fast may ask for. Of material that changes a
/// hundredfold every frame 4 tears springs in 3 of 10000 frames, 16 in none of 54000.
constexpr int most_for_parting = 16;

/// Share of the velocity against it that air may take in a substep: explicit steps bear twice all.
constexpr double most_air_share = 0.5;

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

Simulator::Impl::Impl(const Scene& s) : scene(s) {
  validate(scene);
  workers = Workers(scene.simulation.threads);
  cloth = make_grid(scene.cloth, scene.simulation.gravity.norm());
  build_strain_limit();
  for (const ColliderSpec& spec : scene.colliders) colliders.emplace_back(spec);
  reset();
  check_feasible(scene.simulation, cloth, {"cloth", "ks"});
}

StepReport Simulator::Impl::step() {
  const double dt = 1 / scene.simulation.frames_per_second;
  const State last_good = state;
  const std::vector<MovingCollider> last_colliders = colliders;
  const bool was_disturbed = disturbed;

  must_look = is_apart = false;
  if (!touches()) collider_contacts.reset();  // of colliders that are off now
  allow_work(dt);
  StepReport report;
  bool has_given_way = false;
  const auto take_back = [&] {
    state = last_good;
    colliders = last_colliders;
    disturbed = was_disturbed;
    forget_constraints();
    energy_watch.restart();
  };
  const auto succeeds = [&] {
    try {
      return frame(dt, last_good, report);
    } catch (const Interrupted&) {
      take_back();
      throw;
    }
  };
  while (!succeeds()) {
    take_back();
    if (went_too_far) {
      must_look = true;
      continue;
    }
    if (budget.is_spent()) {
      forget();
      throw Diverged("the frame after t = " + std::to_string(state.time) +
                     " s asks for more than can be solved: it was left after " +
                     std::to_string(report.substeps) + " substeps and " +
                     std::to_string(report.sweeps + report.corrections) + " passes");
    }
    // What is asked of the limit may be at fault, where it is not too few substeps.
    if (strain_limit && is_overpulled && !scene.simulation.substeps && !has_given_way) {
      has_given_way = true;
      strain_limit->give_way();
    } else if (!recover()) {
      forget();
      const std::string retried =
          report.recoveries == 0 ? ""
                                 : " after " + std::to_string(report.recoveries) + " other tries";
      throw Diverged("the state left the finite numbers or gained energy in the frame after t = " +
                     std::to_string(state.time) + " s, with method " + report.method + " and " +
                     std::to_string(report.substeps) + " substeps a frame" + retried);
    }
    ++report.recoveries;
  }

  // Pins and colliders arrive, to the last bit. Pins that the cloth itself blocks stop short.
  for (std::size_t i = 0; i < pin_targets.size(); ++i) {
    arrive_at(pin_targets[i], pin_point(i), state);
    state.velocities.row(pin_point(i)).setZero();
  }
  for (MovingCollider& collider : colliders) collider.arrive();

  is_given = false;
  disturbed = false;
  if (!grips.empty()) finish_grips(dt, last_good);
  if (weighs_colliders) finish_colliders(dt);
  state.time = last_good.time + dt;
  report.contacts = collider_contacts.count();
  if (self_contacts) report.contacts += self_contacts->count();
  return report;
}

bool Simulator::Impl::frame(double dt, const State& before, StepReport& report) {
  const int recoveries = report.recoveries;  // all else is of this attempt
  report = {};
  report.recoveries = recoveries;
  report.method = method->choice.method;
  went_too_far = false;
  is_apart = !must_look && has_colliders() && is_out_of_reach(dt);
  if (is_apart) collider_contacts.reset();
  approach_speed = contact_speed(dt);
  int least = substeps_at_speed(cloth, approach_speed, dt);
  is_fast = least > 1;
  if (follows_tension()) {
    least = substeps_under_tension(dt, std::max(least, method->choice.least_substeps));
    if (!collider_contacts.recovers()) least = std::max(least, substeps_for_parting(dt));
  }
  if (has_air()) {
    const SimulationSpec& spec = scene.simulation;
    wind = wind_at(spec.wind.value_or(Vector3::Zero()), {spec.gusts, spec.seed}, before.time);
    const double rate = air_rate(cloth, scene.cloth.material.drag, air_speed());
    const double steps = std::min(std::ceil(dt * rate / most_air_share), double{max_substeps});
    least = std::max(least, static_cast<int>(steps));
  }
  int steps = method->substeps(scene.simulation, cloth, state.positions, least, workers);
  report.predicted_error = method->choice.predicted_error;
  report.reasons = method->choice.reasons;
  const bool is_unstable = scene.simulation.substeps && is_beyond_stability(dt / steps);
  if (is_unstable) report.reasons.add(Reason::beyond_stability);
  recovers = repairs_ran_out = is_overpulled = false;
  stretch = colliders.empty() || is_apart ? 0 : worst_stretch(cloth, state.positions);

  // Pins and colliders set out for where they must be at the frame's end.
  for (std::size_t i = 0; i < pin_targets.size(); ++i) {
    const int point = pin_point(i);
    state.velocities.row(point) = (pin_targets[i].transpose() - state.positions.row(point)) / dt;
  }
  grips.set_out(dt, state);
  if (!grips.empty()) impulses.setZero(cloth.num_points(), 3);
  if (weighs_colliders) collider_impulses.assign(colliders.size(), {});

  for (double h = dt / steps; steps > 0; --steps, ++report.substeps) {
    // More and shorter ones where tension has come.
    const double left = h * steps;
    const bool looks_again =
        report.substeps > 0 && follows_tension() && !collider_contacts.recovers();
    const int needed = looks_again ? substeps_under_tension(left, steps) : steps;
    if (needed > steps) h = left / (steps = needed);
    if (is_interrupted && is_interrupted()) {
      throw Interrupted("interrupted in the frame after t = " + std::to_string(before.time) + " s");
    }
    if (!substep(h, report)) return false;
  }
  if (!is_good(state)) return false;
  went_too_far = is_apart && longest_row(state.positions - before.positions) > allowed_way;
  if (went_too_far) return false;
  if (report.ran_out > 0) {
    report.reasons.add(Reason::newton_ran_out, "in " + std::to_string(report.ran_out) + " of " +
                                                   std::to_string(report.substeps) + " substeps");
  }
  report.worst_stretch = worst_stretch(cloth, state.positions);
  is_overpulled = cloth.strain_limit && report.worst_stretch > *cloth.strain_limit + overpulled;
  const bool yields = strain_limit && strain_limit->yields();
  if (yields) {
    report.reasons.add(Reason::limit_yields);
  } else if (repairs_ran_out || is_overpulled) {
    report.reasons.add(Reason::passes_ran_out);
  }
  // Where pins or fingers ask for all that the strain limit grants, it pulls without end. That is
  // no fault of the method, but for speeds that no pull explains. A limit that yields stands for
  // it, too.
  const bool may_be_pulled =
      strain_limit && !is_unstable && longest_row(state.velocities) < fastest_given;
  bool is_explained =
      disturbed || (may_be_pulled && (yields || (is_overpulled && report.pinched > 0)));
  if (!is_explained) {
    if (energy_watch.accepts(cloth, scene.simulation.gravity, dt, before, state, colliders,
                             recovers ? recovery_speed : 0, has_air() ? wind.norm() : 0)) {
      return true;
    }
    is_explained = may_be_pulled && (are_pulled_taut(cloth, before.positions) ||
                                     are_pulled_taut(cloth, state.positions));
  }
  if (is_explained) energy_watch.restart();
  return is_explained;
}

bool Simulator::Impl::is_beyond_stability(double h) const {
  const double limit = method->stability_limit();
  if (h * method->omega_max < limit) return false;  // by far the cheaper bound
  return h * omega_max_bound(cloth, state.positions) > limit;
}

bool Simulator::Impl::recover() {
  const SimulationSpec& spec = scene.simulation;
  if (spec.method != "auto" || method->choice.method == refuge) return false;
  const Reasons failed(Reason::method_failed, method->choice.method);
  method = last_resort(spec, cloth, scene.colliders, failed);
  return true;
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
  if (strain_limit->yields()) {
    return substeps_at_tension(cloth, gravity, strain_limit->tension_frequency(), dt, least);
  }
  const TensionInertia& inertia = strain_limit->inertia();
  if (touches()) return substeps_at_tension(cloth, gravity, inertia.frequency(cloth), dt, least);
  const int needed = substeps_at_share(cloth, gravity, inertia.share(dt), dt, least);
  if (needed == least) return least;
  const int at_weight = std::max(least, substeps_at_weight(cloth, gravity, dt));
  return needed > at_weight && is_pulled_without_end() ? at_weight : needed;
}

bool Simulator::Impl::is_pulled_without_end() const {
  return worst_stretch(cloth, state.positions) > *cloth.strain_limit + overpulled ||
         are_pulled_taut(cloth, state.positions);
}

int Simulator::Impl::substeps_for_parting(double dt) const {
  const int least = method->choice.least_substeps;
  const int needed = substeps_at_parting(cloth, state.velocities, dt, least);
  if (needed == least) return 1;
  // Then springs part the faster the shorter the steps.
  if (is_pulled_without_end()) return 1;
  return std::min(needed, most_for_parting * least);
}

bool Simulator::Impl::is_out_of_reach(double dt) {
  const Eigen::AlignedBox3d box(state.positions.colwise().minCoeff().transpose(),
                                state.positions.colwise().maxCoeff().transpose());
  // What pins and springs do beside what it does by itself, hardly ever is as much and an edge
  // more.
  const double edge = shortest_rest_length(cloth);
  const double own = longest_row(state.velocities) + scene.simulation.gravity.norm() * dt;
  allowed_way = 2 * own * dt + edge;
  // Contact begins that much before the surfaces meet.
  const double apart = edge + cloth.thickness;
  return std::none_of(colliders.begin(), colliders.end(), [&](const MovingCollider& collider) {
    return collider.reaches(box, apart + allowed_way + collider.fastest_in(box) * dt);
  });
}

double Simulator::Impl::contact_speed(double dt) const {
  if (!touches()) return 0;
  const double own = longest_row(state.velocities);
  Eigen::AlignedBox3d box(state.positions.colwise().minCoeff().transpose(),
                          state.positions.colwise().maxCoeff().transpose());
  const double fall = scene.simulation.gravity.norm() * dt / 2;  // of the frame itself
  double fastest = 0;
  for (const MovingCollider& collider : colliders) {
    const double speed = own + collider.fastest_in(box);
    if (collider.reaches(box, (speed + fall) * dt)) fastest = std::max(fastest, speed);
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
  if (touches()) {
    for (MovingCollider& collider : colliders) collider.advance(h);
    start = state.positions;
    start_velocities = state.velocities;
  }

  if (has_air()) blow(h);
  const Loads loads{scene.simulation.gravity};
  const Cloth& inert = weigh(h);
  if (&inert == &weighed) {
    report.added_mass = std::max(report.added_mass, strain_limit->inertia().share(h));
  }
  std::visit([&](auto& m) { m.step(inert, loads, h, state, workers); }, method->integrator);
  report.ran_out += std::visit([](const auto& m) { return m.ran_out(); }, method->integrator);
  const int newton_steps =
      std::visit([](const auto& m) { return m.newton_steps(); }, method->integrator);
  spend(1 + newton_steps * visits_of_newton_step());

  if (touches() && !is_good(state)) return false;  // numbers to sort by
  if (strain_limit || touches()) constrain(inert, h, report);
  if (!grips.empty()) add_impulses(h);
  if (weighs_colliders) add_collider_impulses(h);
  return !budget.is_spent();
}

double Simulator::Impl::stretch_after(double h) const {
  if (approach_speed == 0) return stretch;
  const bool is_kept = strain_limit && substeps_at_speed(cloth, approach_speed, h) == 1;
  if (is_kept) return stretch;  // the limit takes back what so little parts
  const double so_far = is_fast ? worst_stretch(cloth, state.positions) : stretch;
  return so_far + approach_speed * h / shortest_rest_length(cloth);
}

void Simulator::Impl::blow(double h) {
  const Points& forces = air.compute(cloth, scene.cloth.material.drag, wind, state, workers);
  state.velocities += h * (forces.array().colwise() * cloth.inv_mass.array()).matrix();
  if (!grips.empty()) impulses += h * forces;
}

Simulator::Simulator(const Scene& scene) : impl_(std::make_unique<Impl>(scene)) {}
Simulator::~Simulator() = default;
Simulator::Simulator(Simulator&&) noexcept = default;
Simulator& Simulator::operator=(Simulator&&) noexcept = default;

StepReport Simulator::step() { return impl_->step(); }
void Simulator::set_interrupt(std::function<bool()> is_interrupted) {
  impl_->is_interrupted = std::move(is_interrupted);
}

void Simulator::reset() { impl_->reset(); }

void Simulator::move_collider(int index, const Pose& target) {
  check_place(target);
  const auto i = static_cast<std::size_t>(index);
  impl_->colliders.at(i).aim(target * scene().colliders[i].offset, frame_duration());
}

void Simulator::place_collider(int index, const Pose& pose) {
  check_place(pose);
  const auto i = static_cast<std::size_t>(index);
  impl_->colliders.at(i).place(pose * scene().colliders[i].offset);
  impl_->disturbed = true;
}

void Simulator::enable_collider(int index, bool enabled) {
  MovingCollider& collider = impl_->colliders.at(static_cast<std::size_t>(index));
  if (collider.enabled() == enabled) return;
  collider.enable(enabled);
  impl_->disturbed = true;
}

void Simulator::move_pin(int index, const Vector3& target) {
  check_place(target);
  impl_->pin_targets.at(static_cast<std::size_t>(index)) = target;
}

void Simulator::place_pin(int index, const Vector3& position) {
  check_place(position);
  const auto pin = static_cast<std::size_t>(index);
  impl_->pin_targets.at(pin) = position;
  impl_->state.positions.row(impl_->pin_point(pin)) = position.transpose();
  impl_->disturbed = true;
}

const Scene& Simulator::scene() const { return impl_->scene; }
const Cloth& Simulator::cloth() const { return impl_->cloth; }
const State& Simulator::state() const { return impl_->state; }
const Pose& Simulator::collider_pose(int index) const {
  return impl_->colliders.at(static_cast<std::size_t>(index)).pose();
}
bool Simulator::collider_enabled(int index) const {
  return impl_->colliders.at(static_cast<std::size_t>(index)).enabled();
}
double Simulator::frame_duration() const { return 1 / impl_->scene.simulation.frames_per_second; }
const MethodChoice& Simulator::choice() const { return impl_->method->choice; }
unsigned Simulator::topology_seq() const { return impl_->topology_seq; }

}  // namespace clothsim
