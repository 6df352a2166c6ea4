#pragma once

#include <ros/time.h>

#include <array>

namespace clothsim_ros {

/// What a node's time goes into, as shares of the time that passes. For one thread.
class TimeShares {
 public:
  enum class Use { nothing, serving, simulating, publishing };

  struct Shares {
    double serving = 0;     // calls and other callbacks, with what they wait for
    double simulating = 0;  // CPU time
    double publishing = 0;  // CPU time
    double kept = 0;        // from the CPU, by other work, while simulating and publishing
  };

  /// Time while it lives counts for `use`, but for that of a Scope inside.
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

  /// Since the last call.
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
  Seconds charged_ = now();         // up to here time is counted
  double start_ = charged_.wall;    // of the shares [s]
  std::array<Seconds, 4> spent_{};  // by Use, since start_
};

}  // namespace clothsim_ros
