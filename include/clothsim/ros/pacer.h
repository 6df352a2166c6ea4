#pragma once

#include <ros/duration.h>
#include <ros/time.h>

#include <optional>
#include <utility>

namespace clothsim_ros {

/// Says when the next frame is due and which time it stands for.
///
/// A frame is due, and stamped, at start + simulated time since the start / realtime_factor, so
/// that stamps are evenly spaced however late the computer is. A run that falls behind for good
/// starts again from now. Time is ROS time, and stands still with it.
///
/// Where the node owns the clock, frames are due by the computer's steady clock, and ROS time goes
/// on by the simulated time of each frame.
class Pacer {
 public:
  /// `realtime_factor` 0: every frame is due at once, and stamped with now.
  Pacer(double realtime_factor, bool owns_clock);

  /// Time until a frame of `frame_duration` [s] is due; zero: now. Where ROS time is another
  /// node's, not longer than until one should ask again.
  ros::WallDuration until_due(double frame_duration);

  /// A frame of `frame_duration` [s] that was due is done. Returns its stamp.
  ros::Time advance(double frame_duration);

  /// The same for a frame out of turn. Its stamp is now, and the next frame is due one frame later.
  ros::Time advance_now(double frame_duration);

  /// The next frame is due one frame from now, as after a pause.
  void restart() { start_.reset(); }

  /// Whether another node's clock has jumped ahead since the last call, as a bag's does, rather
  /// than gone on while frames were computed.
  bool has_jumped() { return std::exchange(has_jumped_, false); }

  /// Whether frames wait for the first time of another node's clock.
  bool waits_for_clock() const { return realtime_factor_ != 0 && pace().isZero(); }

  /// ROS time; zero where another node's has not begun.
  ros::Time now() const;

  /// The time by which frames are due [s].
  double seconds() const { return pace().toSec(); }

 private:
  ros::Time pace() const;

  double realtime_factor_;
  bool owns_clock_;
  double clock_ = 0;  // [s] simulated since the node's start, where the clock is ours
  /// Compares the clock with the computer's.
  void watch_jumps(const ros::Time& now);

  bool has_jumped_ = false;
  ros::Time last_look_;             // at another node's clock; zero: none
  ros::SteadyTime last_steady_;     // when that was
  std::optional<ros::Time> start_;  // of evenly spaced frames
  double elapsed_ = 0;              // [s] from start_ to the last frame
};

}  // namespace clothsim_ros
