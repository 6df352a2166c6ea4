#include "clothsim/ros/stamps.h"

#include <limits>

namespace clothsim_ros {
namespace {

/// tf2 adds the length of its memory, 10 s, to each stamp, whose nanoseconds may be as many as
/// 4.3 s: from later ones on that overflows [s].
constexpr std::uint32_t latest_held = std::numeric_limits<std::uint32_t>::max() - 15;

}  // namespace

double seconds_between(const ros::Time& begin, const ros::Time& end) {
  const double seconds = static_cast<double>(end.sec) - static_cast<double>(begin.sec);
  const double nanoseconds = static_cast<double>(end.nsec) - static_cast<double>(begin.nsec);
  return seconds + 1e-9 * nanoseconds;
}

bool is_ahead(const ros::Time& stamp, const ros::Time& now) {
  return stamp.sec > latest_held || (!now.isZero() && seconds_between(now, stamp) > largest_lead);
}

}  // namespace clothsim_ros
