#include "clothsim/ros/newest_stamps.h"

#include <tf2/buffer_core.h>

#include <algorithm>

#include "clothsim/ros/stamps.h"

namespace clothsim_ros {

bool NewestStamps::is_late(const geometry_msgs::TransformStamped& transform) const {
  const auto newest = of_.find(transform.child_frame_id);
  if (newest == of_.end()) return false;
  const double behind = seconds_between(transform.header.stamp, newest->second);
  return behind > 0 && behind < tf2::BufferCore::DEFAULT_CACHE_TIME;
}

void NewestStamps::add(const geometry_msgs::TransformStamped& transform) {
  ros::Time& newest = of_[transform.child_frame_id];
  newest = std::max(newest, transform.header.stamp);
}

ros::Time NewestStamps::next(const std::string& frame, const ros::Time& now) const {
  const auto newest = of_.find(frame);
  return newest == of_.end() ? now : std::max(now, newest->second + ros::Duration(0, 1));
}

}  // namespace clothsim_ros
