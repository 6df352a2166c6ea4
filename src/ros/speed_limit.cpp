#include "clothsim/ros/speed_limit.h"

#include <ros/console.h>

namespace clothsim_ros {
namespace {

/// A delay up to this gets no warning [s]: transforms may be rare, or come in bunches.
constexpr double short_delay = 0.2;

}  // namespace

double SpeedLimit::share(double way, double frame, const std::string& name) {
  if (way <= speed_ * frame) return 1;
  if (way > speed_ * short_delay && warnings_.passes()) {
    ROS_WARN(
        "tf frame %s is %.3g m ahead of the points it holds: they follow at %g m/s, ~jump_speed",
        name.c_str(), way, speed_);
  }
  return speed_ * frame / way;
}

clothsim::Vector3 SpeedLimit::toward(const clothsim::Vector3& from, const clothsim::Vector3& to,
                                     double frame, const std::string& name) {
  const double s = share((to - from).norm(), frame, name);
  return s == 1 ? to : from + s * (to - from);
}

clothsim::Pose SpeedLimit::toward(const clothsim::Pose& from, const clothsim::Pose& to,
                                  double reach, double frame, const std::string& name) {
  const double angle = from.orientation.angularDistance(to.orientation);
  const double s = share((to.position - from.position).norm() + angle * reach, frame, name);
  if (s == 1) return to;
  return {from.position + s * (to.position - from.position),
          from.orientation.slerp(s, to.orientation)};
}

}  // namespace clothsim_ros
