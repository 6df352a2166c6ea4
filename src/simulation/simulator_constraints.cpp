// The constraints at a substep's end: springs within their limit, points off colliders, the cloth
// off itself.

#include <algorithm>
#include <cmath>

#include "clothsim/dynamics/springs.h"
#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"
#include "clothsim/simulation/cloth_size.h"
#include "simulator_impl.h"

namespace clothsim {
namespace {

/// Smallest number of passes over the constraints in a substep. Most substeps take no more, as
/// warm-started impulses are almost right. A pass costs little compared to the rest of a substep,
/// and with a single one slow waves of tension oscillate for seconds.
constexpr int min_passes = 4;
constexpr int min_passes_alone = 6;

/// Largest number of passes of the projection that follows these passes.
constexpr int max_projection_passes = 600;

/// Most passes over bodies, and points between them and others, in a pass.
constexpr int body_passes = 10;

/// Where only the strain limit acts, passes end at a change of strain_tolerance * shortest spring /
/// precision_alone.
constexpr double precision_alone = 14;

/// While a cloth in contact deforms, passes may end at a change of motion_precision *
/// strain_tolerance (1 % with the usual tolerance) of the rms of the velocities relative to their
/// mean, times h. The error is then no larger than that of the substep, and half to two thirds of
/// the passes are enough. At 4 % a sphere shot through a pile leaves knots, and fingers lose their
/// grip.
constexpr double motion_precision = 2.5;

/// Factor on that change for self contact. The overlap is then as large as the curvature of paths
/// within a substep causes anyway: at 0.1 % it is no smaller, and the passes are seven to nine
/// times as many.
constexpr double folding_precision = 4;

/// Mean square deviation of `count` numbers from their mean.
CLOTHSIM_TARGET_CLONES
double variance(int count, const double* numbers) {
  Half sums[2] = {}, squares[2] = {};
  const double middle = numbers[0];  // near the mean, to preserve digits
  int i = 0;
  for (; i + num_lanes <= count; i += num_lanes) {
    for (int half = 0; half < 2; ++half) {
      const Half x = half_at(numbers + i + half * half_size) - middle;
      sums[half] += x;
      squares[half] += x * x;
    }
  }
  double all = 0, all_squares = 0;
  add_lanes(sums, all);
  add_lanes(squares, all_squares);
  for (; i < count; ++i) {
    all += numbers[i] - middle;
    all_squares += (numbers[i] - middle) * (numbers[i] - middle);
  }
  return std::max(0.0, (all_squares - all * all / count) / count);
}

/// Root mean square of the velocities relative to their mean [m/s].
double speed_within(const Points& velocities) {
  double sum = 0;
  const int count = static_cast<int>(velocities.rows());
  for (int axis = 0; axis < 3; ++axis) sum += variance(count, &velocities(0, axis));
  return std::sqrt(sum);
}

/// x += impulse_time (v - followed), followed = v. `count`: numbers in each array.
CLOTHSIM_TARGET_CLONES
void follow(Eigen::Index count, double impulse_time, const double* velocities, double* followed,
            double* positions) {
#pragma GCC ivdep
  for (Eigen::Index i = 0; i < count; ++i) {
    positions[i] += impulse_time * (velocities[i] - followed[i]);
    followed[i] = velocities[i];
  }
}

/// A change that falls by less than this factor does not fall.
constexpr double falling = 0.98;

/// Passes over cloth between a body and another collider end after so many whose changes did not
/// fall.
constexpr int most_stalled = 10;

/// Whether the changes of passes have ceased to fall.
class Stall {
 public:
  /// To be called after each pass, with its change.
  bool after(double change) {
    since_ = change < falling * least_ ? 0 : since_ + 1;
    least_ = std::min(least_, change);
    return since_ >= most_stalled;
  }

 private:
  double least_ = infinity;
  int since_ = 0;
};

/// Length of the shortest spring; without springs that between two neighbours [m]. Precision is
/// relative to it.
double min_spacing(const Cloth& cloth) {
  if (!cloth.springs.empty() || cloth.num_points() < 2) return shortest_rest_length(cloth);
  return (cloth.rest_positions.row(1) - cloth.rest_positions.row(0)).norm();
}

}  // namespace

void Simulator::Impl::constrain(const Cloth& inert, double h, StepReport& report) {
  const double factor = std::visit(
      [&](const auto& m) { return m.displacement_factor(cloth.damping, h); }, method->integrator);
  const double tolerance = scene.simulation.strain_tolerance;
  const double length = tolerance * min_spacing(cloth);  // [m]
  if (strain_limit) {
    // A frame ends within the limit, and the speed of recovery from colliders is unknown.
    if (frame_context.left <= h || frame_context.recovers) strain_limit->wake();
    strain_limit->warm_start(h, factor, state, workers);
    frame_context.yields = frame_context.yields || strain_limit->yields();
  }
  if (!touches()) return limit_alone(inert, h, factor, length, report);

  const SelfTouches touches_of_itself = [&](const auto& visit) {
    if (self_contacts) self_contacts->for_each_touch(visit);
  };
  followed = state.velocities;
  if (frame_context.lags) lagged_contact.take_back(state.velocities);
  const bool runs_detection = frame_context.steps_left == 0;
  if (runs_detection) plan_detection(h);
  const ContactStep step = contact_step(h, factor, touches_of_itself);

  // First all impulses of the last substep act. Then the strain limit finds the springs at their
  // limit at the positions that result.
  runs_detection ? prepare_contacts(step, report) : refresh_contacts(step);
  holders.warm_start(cloth, step, state);
  if (!attachments.empty()) attachments.prepare(cloth, step, colliders, state);
  follow_velocities(factor * h);
  if (strain_limit) {
    strain_limit->prepare(cloth, factor, state, workers, &start_velocities);
  }
  if (runs_detection) frame_context.tolerances = tolerances_at(h, tolerance, length);
  solve(runs_detection, report);
  if (frame_context.lags) {
    lagged_contact.follow(collider_contacts, self_contacts ? &*self_contacts : nullptr,
                          step.gravity, cells_along(cloth));
  }
  follow_velocities(factor * h);
  if (strain_limit) strain_limit->learn_tension(workers);
  if (!bodies.empty()) end_bodies();
  attachments.project(colliders, state.positions);
  if (self_contacts && runs_detection) by_impulses = state.positions;

  correct_positions(runs_detection, report);

  // Whatever has moved the points, the cloth does not pass through itself.
  if (self_contacts && runs_detection) guard(step, report);
  runs_detection ? end_detection(h) : count_displacement(h);
}

/// Moves points by the changes of their velocities since the last call.
void Simulator::Impl::follow_velocities(double impulse_time) {
  workers.parallel_for(static_cast<int>(followed.size()), [&](int begin, int end) {
    follow(end - begin, impulse_time, state.velocities.data() + begin, followed.data() + begin,
           state.positions.data() + begin);
  });
}

void Simulator::Impl::correct_positions(bool runs_detection, StepReport& report) {
  attachments.fix(true, cloth);
  if (strain_limit) project_positions(cloth, report);
  if (!colliders.empty()) {
    runs_detection ? collider_contacts.project_positions(colliders, cloth, start, state)
                   : collider_contacts.project_near(colliders, cloth, start, state.positions);
  }
  attachments.fix(false, cloth);
}

ContactStep Simulator::Impl::contact_step(double h, double displacement_factor,
                                          const SelfTouches& touches_of_itself) {
  ContactStep step{h, displacement_factor, start, followed, workers};
  step.left = frame_context.left;
  step.gravity =
      std::max(scene.simulation.gravity.norm() + frame_context.external_acceleration, min_gravity);
  step.recovery_factor = collider_contacts.recovery_factor();
  if (!colliders.empty() && frame_context.steps_left == 0) step.stretch = stretch_after(h);
  step.budget = &budget;
  step.touches = &touches_of_itself;
  step.velocities = &start_velocities;
  step.pinched = &collider_contacts.pinches().held();
  if (frame_context.since > h) step.detected_at = &detected_at;
  step.since = frame_context.since;
  step.ahead = h * (frame_context.planned_steps + frame_context.steps_left);
  step.undetected_move = frame_context.max_undetected_move;
  if (!bodies.empty()) step.bodies = &bodies;
  return step;
}

void Simulator::Impl::refresh_contacts(const ContactStep& step) {
  if (self_contacts) self_contacts->refresh(cloth, step, state);
  collider_contacts.refresh(colliders, cloth, step, state);
}

void Simulator::Impl::guard(const ContactStep& step, StepReport& report) {
  const int truncated = self_contacts->guard(cloth, step, by_impulses, state);
  report.held_back += truncated;
  // Springs stay stretched where the limit yields or colliders pinch.
  const bool may_project =
      strain_limit && !strain_limit->yields() && collider_contacts.pinches().count() == 0;
  if (truncated > 0 && may_project) project_beside_truncated(step, report);
}

/// Shortens springs beside truncated points, which the truncation stretches. The guard checks this
/// displacement as well. It does not change velocities.
void Simulator::Impl::project_beside_truncated(const ContactStep& step, StepReport& report) {
  const State held = state;
  project_springs(cloth, max_conflict_passes, report);
  if (!colliders.empty()) {
    collider_contacts.project_again(colliders, cloth, held.positions, state.positions);
  }
  ContactStep guarded{step.h, step.displacement_factor, held.positions, step.drifted, step.workers};
  guarded.budget = step.budget;
  const Points projected = state.positions;  // so that the guard drops no part of it
  self_contacts->guard(cloth, guarded, projected, state);
  state.velocities = held.velocities;
}

int Simulator::Impl::max_limit_passes() const {
  return strain_limit && strain_limit->yields() ? max_conflict_passes : max_passes;
}

void Simulator::Impl::limit_alone(const Cloth& inert, double h, double displacement_factor,
                                  double length, StepReport& report) {
  const StrainLimit::Passes passes =
      strain_limit->solve(inert, displacement_factor, length / precision_alone, min_passes_alone,
                          max_limit_passes(), state, workers);
  report.sweeps += passes.count;
  strain_limit->inertia().give_back(cloth, h, displacement_factor, state);
  strain_limit->learn_tension(workers);
  project_positions(inert, report);
}

void Simulator::Impl::prepare_contacts(const ContactStep& step, StepReport& report) {
  if (self_contacts) self_contacts->prepare(cloth, step, state);
  collider_contacts.prepare(colliders, cloth, step, state);
  if (!colliders.empty()) spend(WorkBudget::point_on_colliders);
  frame_context.recovers = frame_context.recovers || collider_contacts.recovers();

  Pinches& pinches = collider_contacts.pinches();
  if (pinches.count() == 0) return;
  if (self_contacts) self_contacts->release_pinched(pinches, state.velocities);
  if (strain_limit) {
    Points pulls = Points::Zero(cloth.num_points(), 3);
    strain_limit->add_impulses(pulls);
    pulls.array().colwise() *= cloth.inv_mass.array();
    pinches.set_pulls(pulls);
  }
  if (pinches.count() > report.pinched) {
    report.pinched = pinches.count();
    report.pinched_point = pinches.first();
  }
}

PassTolerances Simulator::Impl::tolerances_at(double h, double tolerance, double length) const {
  const double moving = motion_precision * tolerance * h * speed_within(state.velocities);
  const double at_rest = std::min(length / tolerance_per_residual, rest_speed * h);
  PassTolerances result;
  // With self contact springs are solved to the strict bound even in motion: their residuals would
  // keep piles from coming to rest.
  result.stretch = std::max(length / tolerance_per_residual, self_contacts ? 0 : moving);
  result.touch = std::max(at_rest, moving);
  result.fold = std::max(at_rest, folding_precision * moving);
  result.unseen_fold = result.fold - at_rest;  // at rest no change is skipped
  return result;
}

void Simulator::Impl::solve(bool runs_detection, StepReport& report) {
  const PassTolerances& small = frame_context.tolerances;
  // One pass is enough if detection is skipped, no spring is at its limit and no face in contact:
  // contacts of points share no point, and warm-started impulses fit the rest.
  const bool is_limited = strain_limit && !strain_limit->is_idle();
  const int required_passes =
      runs_detection || is_limited || collider_contacts.has_faces() || !attachments.empty()
          ? min_passes
          : 1;
  Pinches& pinches = collider_contacts.pinches();
  const int limit_passes = max_limit_passes();
  // Largest changes of the last passes over springs and over contacts, as displacements [m].
  double stretching = 0, touched = infinity;
  int passes = 0;
  Stall stall;
  while (passes < max_passes) {
    double folding = 0;
    if (strain_limit && passes < limit_passes) {
      // Passes over springs alone repeat while springs change more than contacts did in their last
      // pass, as a pass over contacts takes longer.
      const StrainLimit::Passes springs = strain_limit->solve_passes(
          std::max(small.stretch, touched), limit_passes - passes, state.velocities, workers);
      stretching = springs.change;
      passes += springs.count;
      pinches.add_pulls(state.velocities);
    } else {
      ++passes;
    }
    if (self_contacts) {
      folding = self_contacts->solve_pass(small.unseen_fold, state.velocities, workers);
      budget.spend(static_cast<std::int64_t>(WorkBudget::contact_in_pass * self_contacts->size()));
    }
    const double on_colliders = solve_colliders();
    const double touching = std::max(on_colliders, solve_holders());
    if (!colliders.empty()) spend(1);
    // With self contact or pinched points `touched` stays infinite: one pass over springs a round.
    if (!self_contacts && pinches.count() == 0) touched = touching;
    const bool limited = stretching <= small.stretch || passes >= limit_passes;
    const bool solved = limited && touching <= small.touch && folding <= small.fold;
    // Light cloth between a body and another collider may have no room for all of its contacts.
    const bool may_stall = collider_contacts.is_between_bodies() && attachments.empty();
    if (may_stall && limited && stall.after(on_colliders)) break;
    const bool is_still = stretching == 0 && touching == 0 && folding == 0;  // as in the next pass
    if ((solved && (passes >= required_passes || is_still)) || budget.is_spent()) break;
  }
  report.sweeps += passes;
  report.slipping = pinches.slipping();
}

double Simulator::Impl::solve_holders() {
  double largest = holders.any_slips() ? holders.solve_pass(state.velocities) : 0;
  if (!attachments.empty()) {
    largest = std::max(largest, attachments.solve_pass(bodies, state.velocities));
  }
  return frame_context.h * largest;
}

double Simulator::Impl::solve_colliders() {
  if (bodies.empty()) {
    return collider_contacts.solve_pass(cloth, state.positions, nullptr, state.velocities);
  }
  // Passes over bodies alone take little time, and with the load of bodies solved, those over the
  // light cloth converge fast.
  double first = 0;
  for (int pass = 0; pass < body_passes; ++pass) {
    const double change =
        std::max(body_contacts.solve_pass(bodies),
                 collider_contacts.solve_coupled(cloth, state.positions, bodies, state.velocities));
    if (pass == 0) first = change;
    if (change * frame_context.h <= frame_context.tolerances.touch) break;
  }
  return std::max(first * frame_context.h,
                  collider_contacts.solve_pass(cloth, state.positions, &bodies, state.velocities));
}

int Simulator::Impl::project_springs(const Cloth& inert, int pass_limit, StepReport& report) {
  const int passes = strain_limit->project_positions(inert, scene.simulation.strain_tolerance,
                                                     pass_limit, state.positions, workers);
  report.corrections += passes;
  return passes;
}

void Simulator::Impl::project_positions(const Cloth& inert, StepReport& report) {
  const int passes = project_springs(inert, max_projection_passes, report);
  frame_context.projection_unconverged =
      frame_context.projection_unconverged || passes == max_projection_passes;
}

}  // namespace clothsim
