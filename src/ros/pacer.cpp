#include "clothsim/ros/pacer.h"

#include <algorithm>

#include "clothsim/ros/stamps.h"

namespace clothsim_ros {
namespace {

/// First time of the node's own clock [s]; 0 would mean that there is no time yet.
constexpr double clock_start = 1;

/// How often to read another node's clock [s].
constexpr double poll_period = 0.001;

/// How late a frame may be without a new start: a few frames by the computer's clock; by another
/// node's clock, which may go in large ticks, at least this long [s].
constexpr double frames_caught_up = 4;
constexpr double largest_tick = 0.5;

/// Another node's clock has jumped ahead when it advanced by this much [s], and this many times
/// faster than the computer's clock.
constexpr double shortest_jump = 1;
constexpr double jump_rate = 100;

}  // namespace

Pacer::Pacer(double realtime_factor, bool owns_clock)
    : realtime_factor_(realtime_factor), owns_clock_(owns_clock) {}

ros::Time Pacer::pace() const {
  if (!owns_clock_) return ros::Time::now();
  const ros::SteadyTime now = ros::SteadyTime::now();
  return {now.sec, now.nsec};
}

ros::Time Pacer::now() const {
  return owns_clock_ ? ros::Time(clock_start + clock_) : ros::Time::now();
}

ros::WallDuration Pacer::until_due(double frame_duration) {
  if (realtime_factor_ == 0) return ros::WallDuration(0);

  const bool follows_clock = !owns_clock_ && ros::Time::isSimTime();
  const ros::Time now = pace();
  if (now.isZero()) return ros::WallDuration(poll_period);
  if (follows_clock) watch_jumps(now);
  if (!start_) {
    start_ = now;
    elapsed_ = 0;
  }
  const double period = frame_duration / realtime_factor_;
  const double since_start = seconds_between(*start_, now);
  double wait = elapsed_ + period - since_start;

  // Too late to catch up: this frame is due now. Time ran backwards: it is due in one period.
  const double caught_up = std::max(frames_caught_up * period, follows_clock ? largest_tick : 0);
  const bool ran_back = since_start < elapsed_;
  if (wait < -caught_up || ran_back) {
    start_ = now;
    elapsed_ = ran_back ? 0 : -period;
    wait = ran_back ? period : 0;
  }
  if (follows_clock) wait = std::min(wait, poll_period);
  return ros::WallDuration(std::max(wait, 0.0));
}

void Pacer::watch_jumps(const ros::Time& now) {
  const ros::SteadyTime steady = ros::SteadyTime::now();
  if (!last_look_.isZero()) {
    const double ahead = seconds_between(last_look_, now);
    const double passed = (steady - last_steady_).toSec();
    has_jumped_ = has_jumped_ || (ahead > shortest_jump && ahead > jump_rate * passed);
  }
  last_look_ = now;
  last_steady_ = steady;
}

ros::Time Pacer::advance(double frame_duration) {
  if (realtime_factor_ == 0) return advance_now(frame_duration);

  elapsed_ += frame_duration / realtime_factor_;
  clock_ += frame_duration;
  return owns_clock_ ? now() : later(*start_, elapsed_);
}

ros::Time Pacer::advance_now(double frame_duration) {
  restart();
  clock_ += frame_duration;
  return now();
}

}  // namespace clothsim_ros
