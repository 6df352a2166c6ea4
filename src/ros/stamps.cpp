#include "clothsim/ros/stamps.h"

#include <tf2/buffer_core.h>

#include <algorithm>

namespace clothsim_ros {

double seconds_between(const ros::Time& begin, const ros::Time& end) {
  const double seconds = static_cast<double>(end.sec) - static_cast<double>(begin.sec);
  const double nanoseconds = static_cast<double>(end.nsec) - static_cast<double>(begin.nsec);
  return seconds + 1e-9 * nanoseconds;
}

ros::Time later(const ros::Time& time, double seconds) {
  return seconds < seconds_between(time, ros::TIME_MAX) ? time + ros::Duration(seconds)
                                                        : ros::TIME_MAX;
}

ros::Time latest_stamp(const ros::Time& now) {
  const ros::Time last(latest_held, 0);
  return now.isZero() ? last : std::min(last, later(now, largest_lead));
}

bool is_ahead(const ros::Time& stamp, const ros::Time& now) {
  return stamp.sec > latest_held || (!now.isZero() && seconds_between(now, stamp) > largest_lead);
}

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
