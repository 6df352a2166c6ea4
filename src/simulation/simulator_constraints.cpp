// What holds at a substep's end: springs within their limit, points off colliders, the cloth off
// itself.

#include <algorithm>
#include <cmath>
#include <limits>

#include "clothsim/dynamics/springs.h"
#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"
#include "simulator_impl.h"

namespace clothsim {
namespace {

/// Passes over the constraints in a substep. The least is usual: kept impulses start almost right,
/// and a pass costs little next to the rest, but one alone lets slow waves of tension swing for
/// seconds.
constexpr int min_sweeps = 4;
constexpr int min_sweeps_alone = 6;

/// Passes that repair what those have left, at most.
constexpr int max_corrections = 600;

/// Precision where only the limit acts.
constexpr double precision_alone = 14;

/// While a cloth in contact moves within itself, this many strain tolerances of that speed do: 1 %
/// with the usual tolerance. Errors are those of the steps then, for half to two thirds of the
/// passes. At 4 % a sphere shot through a pile leaves knots, and fingers lose their grip.
constexpr double motion_precision = 2.5;

/// Times as much does for its contacts with itself. What overlaps then is what a step's own
/// curvature leaves over: at 0.1 % it is as much, for seven to nine times the passes.
constexpr double folding_precision = 4;

/// Mean square of `count` numbers beyond their mean.
CLOTHSIM_TARGET_CLONES
double variance(int count, const double* numbers) {
  Lanes sum = {}, squares = {};
  const double middle = numbers[0];  // near it, or what they share would drown what they do not
  int i = 0;
  for (; i + num_lanes <= count; i += num_lanes) {
    const Lanes x = lanes_at(numbers + i) - middle;
    sum += x;
    squares += x * x;
  }
  double all = 0, all_squares = 0;
  for (int lane = 0; lane < num_lanes; ++lane) {
    all += sum[lane];
    all_squares += squares[lane];
  }
  for (; i < count; ++i) {
    all += numbers[i] - middle;
    all_squares += (numbers[i] - middle) * (numbers[i] - middle);
  }
  return std::max(0.0, (all_squares - all * all / count) / count);
}

/// Root mean square of the velocities beyond their mean [m/s].
double speed_within(const Points& velocities) {
  double sum = 0;
  const int count = static_cast<int>(velocities.rows());
  for (int axis = 0; axis < 3; ++axis) sum += variance(count, &velocities(0, axis));
  return std::sqrt(sum);
}

/// Moves points by what has changed of their velocities, of `count` numbers, since they followed.
CLOTHSIM_TARGET_CLONES
void follow(Eigen::Index count, double way, const double* velocities, double* followed,
            double* positions) {
#pragma GCC ivdep
  for (Eigen::Index i = 0; i < count; ++i) {
    positions[i] += way * (velocities[i] - followed[i]);
    followed[i] = velocities[i];
  }
}

/// Of the shortest spring, without springs of two neighbours [m]: what precision is a share of.
double least_spacing(const Cloth& cloth) {
  if (!cloth.springs.empty() || cloth.num_points() < 2) return shortest_rest_length(cloth);
  return (cloth.rest_positions.row(1) - cloth.rest_positions.row(0)).norm();
}

}  // namespace

void Simulator::Impl::constrain(const Cloth& inert, double h, StepReport& report) {
  const double reach =
      std::visit([&](const auto& m) { return m.reach(cloth.damping, h); }, method->integrator);
  const double tolerance = scene.simulation.strain_tolerance;
  const double length = tolerance * least_spacing(cloth);  // [m]
  if (strain_limit) {
    // A frame ends within the limit, and nobody knows how fast colliders push out what is in them.
    if (course.left <= h || course.recovers) strain_limit->wake();
    strain_limit->predict(h, reach, state);
    course.gives_way = course.gives_way || strain_limit->gives_way();
  }
  if (!touches()) return limit_alone(inert, h, reach, length, report);

  const SelfTouches touches_of_itself = [&](const auto& visit) {
    if (self_contacts) self_contacts->for_each_touch(visit);
  };
  followed = state.velocities;
  const bool seeks = course.served == 0;
  if (seeks) plan_search(h);
  const ContactStep step = contact_step(h, reach, touches_of_itself);

  // Impulses that keep points off colliders, the cloth off itself and springs within their limit:
  // first those of the last step, so that springs are held where all of them lead.
  seeks ? begin_contact(step, report) : go_on_in_contact(step);
  holders.warm_start(cloth, step, state);
  follow(followed.size(), reach * h, state.velocities.data(), followed.data(),
         state.positions.data());
  if (strain_limit) strain_limit->begin(cloth, reach, state, workers, &start_velocities);
  if (seeks) course.closeness = precision_of(h, tolerance, length);
  solve(seeks, report);
  follow(followed.size(), reach * h, state.velocities.data(), followed.data(),
         state.positions.data());
  if (strain_limit) strain_limit->learn_tension();
  if (self_contacts && seeks) by_impulses = state.positions;

  // What curvature and early stops have left in the positions.
  if (strain_limit) repair(cloth, report);
  if (!colliders.empty()) {
    seeks ? collider_contacts.correct(colliders, cloth, start, state.positions)
          : collider_contacts.correct_near(colliders, cloth, start, state.positions);
  }

  // Whatever has moved the points, the cloth does not pass through itself.
  if (self_contacts && seeks) guard(step, report);
  seeks ? end_search(h) : count_way(h);
}

ContactStep Simulator::Impl::contact_step(double h, double reach,
                                          const SelfTouches& touches_of_itself) {
  return {h,
          reach,
          start,
          followed,
          workers,
          course.left,
          std::max(scene.simulation.gravity.norm() + course.push, least_gravity),
          collider_contacts.pace(),
          colliders.empty() || course.served > 0 ? 0 : stretch_after(h),
          &budget,
          &touches_of_itself,
          &start_velocities,
          &collider_contacts.pinches().held(),
          course.since > h ? &sought_at : nullptr,
          course.since,
          h * (course.planned + course.served),
          course.may_go};
}

void Simulator::Impl::go_on_in_contact(const ContactStep& step) {
  if (self_contacts) self_contacts->go_on(cloth, step, state);
  collider_contacts.go_on(colliders, cloth, step, state);
}

void Simulator::Impl::guard(const ContactStep& step, StepReport& report) {
  const int held_back = self_contacts->guard(cloth, step, by_impulses, state);
  report.held_back += held_back;
  // Not where more is asked of the limit than it can grant, nor where fingers hold on.
  const bool may_repair =
      strain_limit && !strain_limit->gives_way() && collider_contacts.pinches().count() == 0;
  if (held_back > 0 && may_repair) repair_beside_held(step, report);
}

/// Springs beside points that were held back hang on them. They are shortened, and this way is
/// guarded like any other. It is no velocity.
void Simulator::Impl::repair_beside_held(const ContactStep& step, StepReport& report) {
  const State held = state;
  shorten(cloth, passes_in_vain, report);
  if (!colliders.empty()) {
    collider_contacts.correct_again(colliders, cloth, held.positions, state.positions);
  }
  ContactStep way{step.h, step.reach, held.positions, step.drifted, step.workers};
  way.budget = step.budget;
  const Points repaired = state.positions;  // none of this is left out, as other repairs may be
  self_contacts->guard(cloth, way, repaired, state);
  state.velocities = held.velocities;
}

int Simulator::Impl::most_limit_sweeps() const {
  return strain_limit && strain_limit->gives_way() ? passes_in_vain : max_sweeps;
}

void Simulator::Impl::limit_alone(const Cloth& inert, double h, double reach, double length,
                                  StepReport& report) {
  const StrainLimit::Passes passes =
      strain_limit->solve(inert, reach, length / precision_alone, min_sweeps_alone,
                          most_limit_sweeps(), state, workers);
  report.sweeps += passes.count;
  strain_limit->inertia().give_back(cloth, h, reach, state);
  strain_limit->learn_tension();
  repair(inert, report);
}

void Simulator::Impl::begin_contact(const ContactStep& step, StepReport& report) {
  if (self_contacts) self_contacts->begin(cloth, step, state);
  collider_contacts.begin(colliders, cloth, step, state);
  if (!colliders.empty()) spend(WorkBudget::point_on_colliders);
  course.recovers = course.recovers || collider_contacts.recovers();

  Pinches& pinches = collider_contacts.pinches();
  if (pinches.count() == 0) return;
  if (self_contacts) self_contacts->leave_to(pinches, state.velocities);
  if (strain_limit) {
    Points pulls = Points::Zero(cloth.num_points(), 3);
    strain_limit->add_impulses(1, pulls);
    pulls.array().colwise() *= cloth.inv_mass.array();
    pinches.set_pulls(pulls);
  }
  if (pinches.count() > report.pinched) {
    report.pinched = pinches.count();
    report.pinched_point = pinches.first();
  }
}

Precision Simulator::Impl::precision_of(double h, double tolerance, double length) const {
  const double moving = motion_precision * tolerance * h * speed_within(state.velocities);
  const double at_rest = std::min(length / precision, calm * h);
  Precision result;
  // What the limit leaves over keeps piles from coming to rest.
  result.stretch = std::max(length / precision, self_contacts ? 0 : moving);
  result.touch = std::max(at_rest, moving);
  result.fold = std::max(at_rest, folding_precision * moving);
  result.unseen_fold = result.fold - at_rest;  // at rest all is seen
  return result;
}

void Simulator::Impl::solve(bool seeks, StepReport& report) {
  const Precision& small = course.closeness;
  // One pass solves points on colliders, which are alone, where kept impulses have the rest.
  const bool is_limited = strain_limit && !strain_limit->is_idle();
  const int least = seeks || is_limited || collider_contacts.has_faces() ? min_sweeps : 1;
  Pinches& pinches = collider_contacts.pinches();
  const int limit_sweeps = most_limit_sweeps();
  double stretching = 0, touched = std::numeric_limits<double>::infinity();
  int sweeps = 0;
  while (sweeps < max_sweeps) {
    double folding = 0;
    if (strain_limit && sweeps < limit_sweeps) {
      // Alone while springs change more than contacts last did: these take longer to go through.
      const StrainLimit::Passes passes = strain_limit->sweep(
          std::max(small.stretch, touched), limit_sweeps - sweeps, state.velocities, workers);
      stretching = passes.change;
      sweeps += passes.count;
      pinches.add_pulls(state.velocities);
    } else {
      ++sweeps;
    }
    if (self_contacts) {
      folding = self_contacts->sweep(small.unseen_fold, state.velocities, workers);
      budget.spend(static_cast<std::int64_t>(WorkBudget::contact_in_pass * self_contacts->size()));
    }
    const double touching =
        std::max(collider_contacts.sweep(state.velocities),
                 holders.any_slips() ? course.h * holders.solve_pass(state.velocities) : 0);
    if (!colliders.empty()) spend(1);
    // What fingers hold, or the cloth itself, does not wait for springs.
    if (!self_contacts && pinches.count() == 0) touched = touching;
    const bool limited = stretching <= small.stretch || sweeps >= limit_sweeps;
    const bool solved = limited && touching <= small.touch && folding <= small.fold;
    const bool is_still = stretching == 0 && touching == 0 && folding == 0;  // so is the next pass
    if ((solved && (sweeps >= least || is_still)) || budget.is_spent()) break;
  }
  report.sweeps += sweeps;
  report.slipping = pinches.slipping();
}

int Simulator::Impl::shorten(const Cloth& inert, int most, StepReport& report) {
  const int passes = strain_limit->correct(inert, scene.simulation.strain_tolerance, most,
                                           state.positions, workers);
  report.corrections += passes;
  return passes;
}

void Simulator::Impl::repair(const Cloth& inert, StepReport& report) {
  const int passes = shorten(inert, max_corrections, report);
  course.repairs_ran_out = course.repairs_ran_out || passes == max_corrections;
}

}  // namespace clothsim
