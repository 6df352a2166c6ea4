#pragma once

#include <limits>

#include "reference.h"

namespace clothsim::work_precision {

/// How far a run is from the reference; not a number where there is nothing to compare.
struct Score {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();

  double position = none;       // RMS over points and frames, of the size
  double position_max = none;   // farthest point in any frame, of the size
  double velocity = none;       // RMS over points and frames, of sqrt(g size)
  double energy = none;         // largest difference in any frame, of M g size
  double momentum = none;       // likewise, of M sqrt(g size)
  double centre = none;         // of mass: farthest in any frame, of the size
  double worst_stretch = none;  // of any spring in any frame
  double p99_stretch = none;    // largest 99th percentile of a frame
  double horizon = 0;           // points are compared up to here [s]
};

/// Points and velocities are compared up to the reference's horizon, and have no number where the
/// run is closer than the reference can tell: where its own error there, times the twin's growth,
/// is over a tenth of the run's. The rest counts in all frames the run has.
Score score(const Run&, const Reference&, const Trial&);

}  // namespace clothsim::work_precision
