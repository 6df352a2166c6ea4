#include "clothsim/ros/rates.h"

namespace clothsim_ros {
namespace {

/// Shortest time for a rate [s].
constexpr double shortest_measured = 0.5;

}  // namespace

bool Throttle::passes() {
  const ros::SteadyTime now = ros::SteadyTime::now();
  if (now < next_) return false;
  next_ = now + period_;
  return true;
}

void RateMeter::restart(double now) {
  start_ = now;
  sum_ = 0;
}

std::optional<double> RateMeter::take(double now) {
  const double passed = now - start_;
  const double sum = sum_;
  if (passed >= 0 && passed < shortest_measured) return std::nullopt;
  restart(now);
  if (passed < 0) return std::nullopt;  // time jumped
  return sum / passed;
}

}  // namespace clothsim_ros
