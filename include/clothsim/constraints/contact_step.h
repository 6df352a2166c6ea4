#pragma once

#include <vector>

#include "clothsim/constraints/self_touches.h"
#include "clothsim/model/types.h"
#include "clothsim/model/work_budget.h"
#include "clothsim/model/workers.h"

namespace clothsim {

class RigidBodies;

/// Least gravity [m/s^2] for the weight of a cloth in contact: cloth without gravity is pressed and
/// pulled, too.
inline constexpr double min_gravity = 9.81;

/// Share of an overlap that a step corrects. A correction of all of it would add energy: a cloth on
/// a tip would shake for ever, and so would piles, whose warm-started impulses integrate it.
inline constexpr double overlap_share = 0.01;

/// Contact is solved at least to this speed [m/s], however short the steps: the residual of each
/// step shakes a cloth at rest, and a residual of friction lets it creep.
inline constexpr double rest_speed = 5e-4;

/// Longest substep where contact or the strain limit act, and longest time between two detections
/// [s]. With longer ones a cloth trembles on a sphere, and a hanging one deviates by more than the
/// tolerance of the limit (see docs/experiments.md).
inline constexpr double longest_step = 3e-3;

/// Most passes where constraints may conflict: over a strain limit that yields, where more would
/// only pull harder, and over triangles in a collider, each of which may move its neighbours in.
inline constexpr int max_conflict_passes = 50;

/// A step, for the detection of contacts after it.
struct ContactStep {
  double h;                    // [s]
  double displacement_factor;  // share of h for which an impulse of the step moves a point
  const Points& start;         // positions at its start [m]
  const Points& drifted;       // velocities that moved the points to the present positions [m/s]
  const Workers& workers;
  double left = 0;               // time until the frame's end, with this step [s]
  double gravity = min_gravity;  // at least min_gravity [m/s^2]
  double recovery_factor = 1;    // factor on the recovery speed, see recovery_factor_after()
  double stretch = 0;            // l / L0 - 1 of springs at its end, at most
  WorkBudget* budget = nullptr;  // of the frame; none: no bound
  const SelfTouches* touches = nullptr;  // in this step; none: the cloth does not touch itself
  const Points* velocities = nullptr;    // at its start [m/s]; none: `drifted`
  // By point, whether colliders hold it once contacts have been found; none or empty: none.
  const std::vector<char>* pinched = nullptr;
  // For steps that use the contacts of an earlier detection:
  const Points* detected_at = nullptr;  // positions at the detection; none: start
  double since = h;                     // time since the detection, at the step's end [s]
  double ahead = h;                     // time until the next detection [s]
  double undetected_move = 0;           // displacement of points until then, beyond the step's [m]
  RigidBodies* bodies = nullptr;        // in this step; none: all colliders are kinematic

  void spend(std::int64_t visits) const {
    if (budget) budget->spend(visits);
  }
  bool is_spent() const { return budget && budget->is_spent(); }
};

}  // namespace clothsim
