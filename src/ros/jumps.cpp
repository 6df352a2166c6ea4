#include "clothsim/ros/jumps.h"

#include <ros/console.h>

#include <algorithm>

namespace clothsim_ros {
namespace {

/// A moving frame may stand between two transforms for this long [s]. Frames of 10 Hz, and one
/// lost.
constexpr double longest_pause = 0.2;

/// Shorter frames of simulation count as this long [s], as they do not get transforms more often.
constexpr double shortest_frame = 1.0 / 90;

/// Largest factor between a continued motion's speed and its last one: transforms come in bunches,
/// and accelerate.
constexpr double speeding_up = 3;

/// A delay up to this gets no warning [s]: transforms may be rare, or come in bunches.
constexpr double short_delay = 0.2;

}  // namespace

bool JumpWatch::jumps(double distance, double frame) {
  since_ += frame;
  if (distance == 0) return false;
  const bool was_moving = since_ <= std::max(longest_pause, frame);
  const double farthest = std::max(jump_speed_ * std::max(frame, shortest_frame),
                                   was_moving ? speeding_up * speed_ * since_ : 0);
  speed_ = distance / (was_moving ? since_ : frame);
  since_ = 0;
  return distance > farthest;
}

double SpeedLimit::share(double distance, double frame, const std::string& name) {
  if (distance <= speed_ * frame) return 1;
  if (distance > speed_ * short_delay && warnings_.passes()) {
    ROS_WARN(
        "tf frame %s is %.3g m ahead of the points it holds: they follow at %g m/s, ~jump_speed",
        name.c_str(), distance, speed_);
  }
  return speed_ * frame / distance;
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
