#pragma once

#include <string>
#include <vector>

#include "clothsim/simulation/simulator.h"

namespace clothsim {

/// Greatest depth of a point or triangle of the cloth in a collider [m], 0 where none is: how far
/// it must move to be out. A two-sided plane has no inside.
double deepest_penetration(const Simulator&);

/// What a whole run did. Cost counts the steps alone, without setting up and writing files.
struct RunReport {
  /// Counts a frame in.
  void add(const StepReport&);

  std::string scene;                   // file
  std::vector<std::string> overrides;  // "key=value"
  long long frames = 0;
  double wall_seconds = 0;
  double cpu_seconds = 0;  // of all threads
  StepReport last_frame;
  int recoveries = 0;       // frames taken back and tried again
  long long ran_out = 0;    // substeps whose method stopped iterating before its tolerance
  long long held_back = 0;  // moves of points cut short, summed over the steps
  int pinched = 0;          // points that two colliders left no room, most at once
  int pinched_point = -1;   // one of them
  std::string error;        // that ended it; the simulator then holds the last good frame
};

/// The report of a run that left `simulator` as it is, as YAML in SI units.
std::string to_yaml(const RunReport&, const Simulator& simulator);

}  // namespace clothsim
