#pragma once

#include <ros/time.h>

namespace clothsim_ros {

/// Lets one message through in each period, from the first on. Goes by the computer's clock:
/// ROS_WARN_THROTTLE goes by ROS time, which stands or jumps, and keeps silent until the first
/// period of it is over.
class Throttle {
 public:
  explicit Throttle(const ros::WallDuration& period) : period_(period) {}

  /// Whether a message may pass now.
  bool passes();

 private:
  ros::WallDuration period_;
  ros::SteadyTime next_;  // when one may pass again
};

}  // namespace clothsim_ros
