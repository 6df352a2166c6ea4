#pragma once

#include "clothsim/model/types.h"

namespace clothsim {

/// Changes of a pass up to which constraints count as solved, as displacements in its step [m].
struct PassTolerances {
  double stretch = 0;      // of springs
  double touch = 0;        // of contact with colliders
  double fold = 0;         // of self contact
  double unseen_fold = 0;  // changes that passes over self contacts skip
};

/// Data of one try of a frame.
struct FrameContext {
  double dt = 0;           // [s]
  double h = 0;            // of the current substep [s]
  double left = 0;         // of the frame, with the current substep [s]
  double motion_step = 0;  // longest step, without the bound of springs [s]
  // For substeps that skip detection, see simulator_search.cpp.
  int planned_steps = 0;           // substeps for which this one detects, including it
  int steps_left = 0;              // next substeps that may still skip detection
  double since = 0;                // time since the detection, with the current substep [s]
  double undetected_move = 0;      // displacement of a point and a collider since then, at most [m]
  double max_undetected_move = 0;  // the same until the next detection [m]
  double collider_speed = 0;       // largest of colliders in reach until then [m/s]
  PassTolerances tolerances = {};  // of the solution, since the detection
  bool is_apart = false;           // all colliders are expected out of reach
  double allowed_displacement = 0;      // displacement of points for which this holds [m]
  double approach_speed = 0;            // of colliders in reach relative to the cloth [m/s]
  bool is_fast = false;                 // at that speed springs may be torn open within the frame
  double stretch = 0;                   // worst at the frame's start, where colliders need it
  Vector3 wind{0, 0, 0};                // [m/s], where there is air
  double external_acceleration = 0;     // largest by external forces [m/s^2]
  bool lifts = false;                   // the offset from colliders grows
  bool recovers = false;                // colliders have pushed out points
  bool projection_unconverged = false;  // some springs stayed over their limit
  bool yields = false;                  // the strain limit yielded in a substep
  bool lags = false;                    // lagged impulses of contact act in the substep
};

/// Result of one try of a frame.
enum class Outcome {
  good,
  went_too_far,  // points moved too far for a frame without detection at colliders
  failed         // the state is impossible, or the budget is spent
};

}  // namespace clothsim
