#pragma once

#include <limits>
#include <string>
#include <vector>

#include "stepper.h"

namespace clothsim::work_precision {

/// The states at the frames' ends.
using Trajectory = std::vector<State>;

enum class Outcome {
  done,
  failed,   // diverged: the states of the frames before are kept
  stopped,  // over its budget: likewise
};
const char* name_of(Outcome);

struct Run {
  Outcome outcome = Outcome::done;
  Trajectory trajectory;
  std::string method;  // the last frame's, as it reports it
  int substeps = 0;    // likewise
  double predicted_error = std::numeric_limits<double>::quiet_NaN();  // where it predicts one
  double sweeps = 0;  // passes over the constraints in a substep, mean over the run
  double cost = 0;    // CPU milliseconds per simulated second
  int repeats = 0;    // cost is the least of so many runs
};

/// How long a run may take, in all [CPU s].
struct Budget {
  double repeat = 0.5;  // repeated, up to three times, while all together took less
  double stop = std::numeric_limits<double>::infinity();  // stopped when one alone took more
};

/// Runs `frames` frames of a fresh stepper. Only step() counts as cost.
Run run(const StepperMaker&, int frames, const Budget& = {});

}  // namespace clothsim::work_precision
