#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>

#include <cstdint>
#include <limits>
#include <string>
#include <unordered_map>

namespace clothsim_ros {

/// Largest lead of a transform's stamp over now [s]: clocks of machines differ, some nodes date
/// their transforms a little forward, and /clock may go in large ticks.
inline constexpr double largest_lead = 2;

/// Latest stamp that tf2 can hold [s]: it adds the length of its memory, 10 s, to each stamp, whose
/// nanoseconds may amount to 4.3 s; later stamps overflow.
inline constexpr std::uint32_t latest_held = std::numeric_limits<std::uint32_t>::max() - 15;

/// [s]; negative where `end` is earlier. ros::Duration throws beyond 68 years.
double seconds_between(const ros::Time& begin, const ros::Time& end);

/// `seconds` after `time`, or the end of ros::Time where that comes before.
ros::Time later(const ros::Time& time, double seconds);

/// The last stamp that is not ahead, see is_ahead().
ros::Time latest_stamp(const ros::Time& now);

/// Whether a stamp is too far ahead of now, or beyond the range of tf2. Before time has begun
/// (`now` is zero), none is ahead.
bool is_ahead(const ros::Time& stamp, const ros::Time& now);

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
