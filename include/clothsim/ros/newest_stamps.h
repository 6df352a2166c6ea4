#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>

#include <string>
#include <unordered_map>

namespace clothsim_ros {

/// The newest stamp of each tf frame. Nobody here looks for the past, and the more of it tf2 holds,
/// the longer it takes to find the place of each late transform.
class NewestStamps {
 public:
  /// Whether a newer transform of the frame came before. False where it is older than all that tf2
  /// may hold: tf2 refuses that at once and says so.
  bool is_late(const geometry_msgs::TransformStamped&) const;

  void add(const geometry_msgs::TransformStamped&);

  /// `now`, or just after the newest of the frame.
  ros::Time next(const std::string& frame, const ros::Time& now) const;
  void clear() { of_.clear(); }

 private:
  std::unordered_map<std::string, ros::Time> of_;  // frame
};

}  // namespace clothsim_ros
