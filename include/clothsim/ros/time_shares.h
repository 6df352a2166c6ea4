#pragma once

#include <ros/callback_queue_interface.h>
#include <ros/time.h>

#include <array>

namespace clothsim_ros {

/// A node's use of time, as shares of the elapsed time. For one thread.
class TimeShares {
 public:
  enum class Use { nothing, serving, simulating, publishing };

  struct Shares {
    double serving = 0;     // calls and other callbacks, including their waits
    double simulating = 0;  // CPU time
    double publishing = 0;  // CPU time
    double kept = 0;        // kept from the CPU by other programs while simulating and publishing
  };

  /// Counts the time of its life for `use`, except that of a Scope inside.
  class Scope {
   public:
    Scope(TimeShares&, Use);
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    TimeShares& shares_;
    Use outer_;
  };

  /// The shares since the last call.
  Shares take();

 private:
  struct Seconds {
    double wall = 0;
    double cpu = 0;
  };

  static Seconds now();
  void charge();
  Seconds& at(Use use) { return spent_[static_cast<size_t>(use)]; }

  Use use_ = Use::nothing;
  Seconds charged_ = now();         // time is counted up to here
  double start_ = charged_.wall;    // of the shares [s]
  std::array<Seconds, 4> spent_{};  // by Use, since start_
};

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
