#pragma once

#include <string>

#include "clothsim/ros/throttle.h"
#include "clothsim/shapes/collider.h"

namespace clothsim_ros {

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
  /// The share from 0 to 1 of a way [m] that is within the limit.
  double share(double way, double frame, const std::string& name);

  double speed_;
  Throttle warnings_{ros::WallDuration(5)};
};

}  // namespace clothsim_ros
