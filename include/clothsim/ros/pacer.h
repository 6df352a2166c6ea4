#pragma once

#include <ros/duration.h>
#include <ros/time.h>

#include <optional>
#include <utility>

namespace clothsim_ros {

/// Computes when the next frame is due, and its stamp.
///
/// A frame is due, and stamped, at start + simulated time since the start / realtime_factor, so
/// that stamps are evenly spaced even if frames are late. A run that falls too far behind starts
/// again from now. Time is ROS time, and stands still with it.
///
/// Where the node owns the clock, frames are due by the computer's steady clock, and ROS time
/// advances by the simulated time of each frame.
class Pacer {
 public:
  /// `realtime_factor` 0: every frame is due at once, and stamped with now.
  Pacer(double realtime_factor, bool owns_clock);

  /// Time until a frame of `frame_duration` [s] is due; zero: now. With another node's clock at
  /// most the time until the next query.
  ros::WallDuration until_due(double frame_duration);

  /// To be called after a due frame of `frame_duration` [s]. Returns its stamp.
  ros::Time advance(double frame_duration);

  /// The same for an extra frame. Its stamp is now, and the next frame is due one frame later.
  ros::Time advance_now(double frame_duration);

  /// The next frame is due one frame from now, as after a pause.
  void restart() { start_.reset(); }

  /// Whether another node's clock has jumped ahead since the last call, as a bag's does, rather
  /// than advanced while frames were computed.
  bool has_jumped() { return std::exchange(has_jumped_, false); }

  /// Whether frames wait for the first time of another node's clock.
  bool waits_for_clock() const { return realtime_factor_ != 0 && pace().isZero(); }

  /// ROS time; zero before the first time of another node's clock.
  ros::Time now() const;

  /// The time that decides when frames are due [s].
  double seconds() const { return pace().toSec(); }

 private:
  ros::Time pace() const;

  double realtime_factor_;
  bool owns_clock_;
  double clock_ = 0;  // [s] simulated since the node's start, where the node owns the clock
  /// Compares the clock with the computer's.
  void watch_jumps(const ros::Time& now);

  bool has_jumped_ = false;
  ros::Time last_look_;             // of another node's clock; zero: none
  ros::SteadyTime last_steady_;     // the steady clock at last_look_
  std::optional<ros::Time> start_;  // of the evenly spaced frames
  double elapsed_ = 0;              // [s] from start_ to the last frame
};

}  // namespace clothsim_ros
