#pragma once

#include <string>
#include <vector>

#include "clothsim/simulation/simulator.h"

namespace clothsim {

/// Greatest depth of a point or triangle of the cloth in a collider [m], 0 where there is none: the
/// distance that it must move to be out. A two-sided plane has no inside.
double deepest_penetration(const Simulator&);

/// Statistics of a whole run. Times are those of the steps alone, without setup and writing of
/// files.
struct RunReport {
  /// Adds a frame.
  void add(const StepReport&);

  std::string scene;                   // file
  std::vector<std::string> overrides;  // "key=value"
  long long frames = 0;
  double wall_seconds = 0;
  double cpu_seconds = 0;  // of all threads
  StepReport last_frame;
  int recoveries = 0;       // frames undone and repeated
  long long ran_out = 0;    // substeps whose method stopped iterating before its tolerance
  long long held_back = 0;  // moves of points cut short, summed over the steps
  int pinched = 0;          // pinched points, most at once
  int pinched_point = -1;   // the number of one of them
  std::string error;        // that ended the run; the simulator then holds the last good frame
};

/// The report of a run that ended in the state of `simulator`, as YAML in SI units.
std::string to_yaml(const RunReport&, const Simulator& simulator);

}  // namespace clothsim
