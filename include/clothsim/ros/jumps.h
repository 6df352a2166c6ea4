#pragma once

#include <limits>
#include <string>

#include "clothsim/ros/rates.h"
#include "clothsim/shapes/collider.h"

namespace clothsim_ros {

/// Detects jumps of a tf frame. Depends on the transforms and simulated time only, so that a run is
/// reproducible; a frame may be broadcast less often than frames are simulated.
class JumpWatch {
 public:
  /// A frame at rest that moves faster than `jump_speed` [m/s] jumps.
  explicit JumpWatch(double jump_speed) : jump_speed_(jump_speed) {}

  /// To be called for each `frame` [s] of simulation, with the distance of the transform from the
  /// last one [m]: is it a jump?
  bool jumps(double distance, double frame);

 private:
  double jump_speed_;
  double since_ = std::numeric_limits<double>::infinity();  // [s] since the last change
  double speed_ = 0;                                        // at the last change [m/s]
};

/// Bounds the speed of points that tf frames hold. A cloth that is pulled metres long within one
/// frame of simulation takes minutes; so where a tf frame jumps, its points travel at bounded
/// speed. The bound depends only on `frame` [s], the duration of a frame of simulation, so that a
/// run is reproducible.
class SpeedLimit {
 public:
  /// `speed`: the bound [m/s].
  explicit SpeedLimit(double speed) : speed_(speed) {}

  /// The place that a point reaches on its way from `from` to `to` [m]. Warns of the tf frame
  /// `name` where the way takes long.
  clothsim::Vector3 toward(const clothsim::Vector3& from, const clothsim::Vector3& to, double frame,
                           const std::string& name);

  /// The same for a frame whose points are at most `reach` [m] from its origin.
  clothsim::Pose toward(const clothsim::Pose& from, const clothsim::Pose& to, double reach,
                        double frame, const std::string& name);

 private:
  /// The share from 0 to 1 of a distance [m] that is within the limit.
  double share(double distance, double frame, const std::string& name);

  double speed_;
  Throttle warnings_{ros::WallDuration(5)};
};

}  // namespace clothsim_ros
