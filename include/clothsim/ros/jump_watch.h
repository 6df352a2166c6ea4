#pragma once

#include <limits>

namespace clothsim_ros {

/// Tells where a tf frame jumps from where it moves. It goes by the transforms and by simulated
/// time alone, so that a run repeats, and knows that a frame may be broadcast less often than is
/// simulated.
class JumpWatch {
 public:
  /// Of a frame that is faster than `jump_speed` [m/s] without having been on the move.
  explicit JumpWatch(double jump_speed) : jump_speed_(jump_speed) {}

  /// To be called for each `frame` [s] of simulation, with how far the transform has gone since the
  /// last one [m]: is that a jump?
  bool jumps(double way, double frame);

 private:
  double jump_speed_;
  double since_ = std::numeric_limits<double>::infinity();  // [s] the last change
  double speed_ = 0;                                        // of that [m/s]
};

}  // namespace clothsim_ros
