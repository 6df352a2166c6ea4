#pragma once

#include <ros/callback_queue_interface.h>

#include "clothsim/ros/time_shares.h"

namespace clothsim_ros {

/// Passes callbacks on to a queue, and counts the time in them as serving.
class TimedCallbacks : public ros::CallbackQueueInterface {
 public:
  /// Both must outlive this and the callbacks. The callbacks must be called in the thread of
  /// `time`.
  TimedCallbacks(ros::CallbackQueueInterface& queue, TimeShares& time)
      : queue_(queue), time_(time) {}

  void addCallback(const ros::CallbackInterfacePtr&, std::uint64_t owner) override;
  void removeByID(std::uint64_t owner) override { queue_.removeByID(owner); }

 private:
  ros::CallbackQueueInterface& queue_;
  TimeShares& time_;
};

}  // namespace clothsim_ros
