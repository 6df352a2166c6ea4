#pragma once

#include <ros/time.h>

#include <cstdint>
#include <limits>

namespace clothsim_ros {

/// How far the stamp of a transform may lie ahead of now [s]: clocks of machines differ, some nodes
/// date theirs a little forward, and /clock may go in large ticks.
inline constexpr double largest_lead = 2;

/// tf2 adds the length of its memory, 10 s, to each stamp, whose nanoseconds may be as many as
/// 4.3 s: from later ones on that overflows [s].
inline constexpr std::uint32_t latest_held = std::numeric_limits<std::uint32_t>::max() - 15;

/// [s]; negative where `end` is the earlier one. ros::Duration throws beyond 68 years.
double seconds_between(const ros::Time& begin, const ros::Time& end);

/// `seconds` after `time`, or the end of ros::Time where that comes before.
ros::Time later(const ros::Time& time, double seconds);

/// The last stamp that is not ahead, see is_ahead().
ros::Time latest_stamp(const ros::Time& now);

/// Whether a stamp lies too far ahead of now, or is none that tf2 can hold. As long as time has not
/// begun (`now` is zero), none lies ahead.
bool is_ahead(const ros::Time& stamp, const ros::Time& now);

}  // namespace clothsim_ros
