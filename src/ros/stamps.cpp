#include "clothsim/ros/stamps.h"

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

}  // namespace clothsim_ros
