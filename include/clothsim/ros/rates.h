#pragma once

#include <ros/time.h>

#include <optional>

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

/// Measures an amount per second, such as simulated time.
class RateMeter {
 public:
  /// Discards the amount before `now` [s], as after a pause.
  void restart(double now);

  void add(double amount) { sum_ += amount; }

  /// Amount per second since the last call; empty where too little time passed.
  std::optional<double> take(double now);

 private:
  double start_ = 0;  // [s]
  double sum_ = 0;    // since start_
};

}  // namespace clothsim_ros
