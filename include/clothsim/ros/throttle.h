#pragma once

#include <ros/time.h>

namespace clothsim_ros {

/// Passes one message in each period, beginning with the first message. By the computer's clock:
/// ROS_WARN_THROTTLE uses ROS time, which may stand or jump, and is silent during the first period.
class Throttle {
 public:
  explicit Throttle(const ros::WallDuration& period) : period_(period) {}

  /// Whether a message may pass now.
  bool passes();

 private:
  ros::WallDuration period_;
  ros::SteadyTime next_;  // time of the next pass
};

}  // namespace clothsim_ros
