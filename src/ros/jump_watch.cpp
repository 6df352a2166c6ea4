#include "clothsim/ros/jump_watch.h"

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

}  // namespace

bool JumpWatch::jumps(double way, double frame) {
  since_ += frame;
  if (way == 0) return false;
  const bool was_moving = since_ <= std::max(longest_pause, frame);
  const double farthest = std::max(jump_speed_ * std::max(frame, shortest_frame),
                                   was_moving ? speeding_up * speed_ * since_ : 0);
  speed_ = way / (was_moving ? since_ : frame);
  since_ = 0;
  return way > farthest;
}

}  // namespace clothsim_ros
