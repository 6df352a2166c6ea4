#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>

#include <string>
#include <unordered_map>

namespace clothsim_ros {

/// The newest stamp of each tf frame. This node never looks up the past, and the more of it tf2
/// holds, the longer it takes to insert each late transform.
class NewestStamps {
 public:
  /// Whether a newer transform of the frame came before. False where it is older than tf2's whole
  /// memory: tf2 refuses that at once, with a message.
  bool is_late(const geometry_msgs::TransformStamped&) const;

  void add(const geometry_msgs::TransformStamped&);

  /// `now`, or just after the newest stamp of the frame.
  ros::Time next(const std::string& frame, const ros::Time& now) const;
  void clear() { of_.clear(); }

 private:
  std::unordered_map<std::string, ros::Time> of_;  // frame
};

}  // namespace clothsim_ros
