#pragma once

#include <limits>

namespace clothsim_ros {

/// Detects jumps of a tf frame. Depends on the transforms and simulated time only, so that a run is
/// reproducible; a frame may be broadcast less often than frames are simulated.
class JumpWatch {
 public:
  /// A frame at rest that moves faster than `jump_speed` [m/s] jumps.
  explicit JumpWatch(double jump_speed) : jump_speed_(jump_speed) {}

  /// To be called for each `frame` [s] of simulation, with the distance of the transform from the
  /// last one [m]: is it a jump?
  bool jumps(double way, double frame);

 private:
  double jump_speed_;
  double since_ = std::numeric_limits<double>::infinity();  // [s] since the last change
  double speed_ = 0;                                        // at the last change [m/s]
};

}  // namespace clothsim_ros
