#pragma once

#include <vector>

#include "clothsim/constraints/self_touches.h"
#include "clothsim/model/types.h"
#include "clothsim/model/work_budget.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// Contact takes a cloth to weigh as much as on Earth at least: where there is no gravity it is
/// pressed and pulled all the same [m/s^2].
inline constexpr double min_gravity = 9.81;

/// Share of an overlap that a step works off. All of it would feed energy to what is pressed on: a
/// cloth on a tip would shake for ever, and so would piles, whose kept impulses integrate it.
inline constexpr double overlap_share = 0.01;

/// Contact is solved to this speed at least [m/s], however short the steps: what is left of each
/// step's solution shakes a cloth that lies, and what friction leaves over, creeps.
inline constexpr double rest_speed = 5e-4;

/// Longest substep where contact or the strain limit act, and longest that steps go on with what
/// was near before [s]: longer ones tremble on a sphere and hang farther off than the limit's
/// tolerance leaves (see docs/experiments.md).
inline constexpr double longest_step = 3e-3;

/// Passes at what may be impossible, at most: over a strain limit that yields, where more would
/// only pull harder, and over triangles in a collider, each of which may move its neighbours in.
inline constexpr int passes_in_vain = 50;

/// The step after which contacts are sought.
struct ContactStep {
  double h;                    // [s]
  double displacement_factor;  // share of h for which an impulse given in the step moves a point
  const Points& start;         // positions at its start [m]
  const Points& drifted;       // the velocities that brought the points where they are [m/s]
  const Workers& workers;
  double left = 0;               // until the frame's end, with this step [s]
  double gravity = min_gravity;  // [m/s^2], no less
  double recovery_factor = 1;    // of what comes out of a collider, see recovery_factor_after()
  double stretch = 0;            // l / L0 - 1 that springs may have at its end
  WorkBudget* budget = nullptr;  // of the frame; none: all is done
  const SelfTouches* touches = nullptr;  // in this step; none: the cloth does not touch itself
  const Points* velocities = nullptr;    // at its start [m/s]; none: those that drifted
  // By point, whether colliders hold it when contacts have been found; none or empty: none.
  const std::vector<char>* held = nullptr;
  // Of steps that go on with contacts of one that sought them.
  const Points* detected_at = nullptr;  // positions when they were sought; none: start
  double since = h;                     // then, at its end [s]
  double ahead = h;                     // until they are sought anew [s]
  double way = 0;                       // that points may go until then, beyond the step's [m]

  void spend(std::int64_t visits) const {
    if (budget) budget->spend(visits);
  }
  bool is_spent() const { return budget && budget->is_spent(); }
};

}  // namespace clothsim
