#pragma once

#include <limits>
#include <string>
#include <vector>

#include "stepper.h"

namespace clothsim::work_precision {

/// The states at the ends of frames.
using Trajectory = std::vector<State>;

enum class Outcome {
  done,
  failed,   // diverged: the states of the frames before are kept
  stopped,  // over its budget: the states of the frames before are kept
};
const char* name_of(Outcome);

struct Run {
  Outcome outcome = Outcome::done;
  Trajectory trajectory;
  std::string method;  // of the last frame, as reported
  int substeps = 0;    // of the last frame
  double predicted_error = std::numeric_limits<double>::quiet_NaN();  // if predicted
  double sweeps = 0;  // passes over the constraints in a substep, mean over the run
  double cost = 0;    // CPU milliseconds per simulated second
  int repeats = 0;    // cost is the minimum of this many runs
};

/// Budget of a run, in all [CPU s].
struct Budget {
  double repeat = 0.5;     // repeated, up to three times, while the sum is below
  double stop = infinity;  // stopped when one run takes more
};

/// Runs `frames` frames of a new stepper. Only step() counts as cost.
Run run(const StepperMaker&, int frames, const Budget& = {});

}  // namespace clothsim::work_precision
