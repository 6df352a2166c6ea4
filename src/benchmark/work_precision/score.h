#pragma once

#include <limits>

#include "reference.h"

namespace clothsim::work_precision {

/// Errors of a run against the reference; NaN where there is nothing to compare.
struct Score {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();

  double position = none;       // RMS over points and frames, of the size
  double position_max = none;   // farthest point in any frame, of the size
  double velocity = none;       // RMS over points and frames, of sqrt(g size)
  double energy = none;         // largest difference in any frame, of M g size
  double momentum = none;       // largest difference in any frame, of M sqrt(g size)
  double centre = none;         // of mass: largest distance in any frame, of the size
  double worst_stretch = none;  // of any spring in any frame
  double p99_stretch = none;    // largest 99th percentile of a frame
  double horizon = 0;           // points are compared up to here [s]
};

/// Points and velocities are compared up to the reference's horizon. They are NaN where the run is
/// closer than the reference can resolve: where its own error there, times the twin's growth, is
/// over a tenth of the run's. The other errors use all frames of the run.
Score score(const Run&, const Reference&, const Trial&);

}  // namespace clothsim::work_precision
