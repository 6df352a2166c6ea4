#pragma once

#include <ros/time.h>

#include <array>

namespace clothsim_ros {

/// What a thread's CPU time goes into. For one thread.
class CpuShares {
 public:
  enum class Use { serving, simulating, publishing };

  /// CPU time spent while it lives counts for `use`, but for that of a Scope inside.
  class Scope {
   public:
    Scope(CpuShares&, Use);
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    CpuShares& shares_;
    Use outer_;
  };

  /// By Use: CPU seconds per second of wall time since the last call.
  std::array<double, 3> take();

 private:
  void charge();

  Use use_ = Use::serving;
  double charged_ = 0;               // [s] of the thread's CPU time that is counted
  std::array<double, 3> seconds_{};  // by Use, since start_
  ros::SteadyTime start_;
};

}  // namespace clothsim_ros
