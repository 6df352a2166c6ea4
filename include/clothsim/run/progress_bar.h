#pragma once

#include <chrono>

namespace clothsim {

/// A bar on standard error for a long run. Silent where standard error is not a terminal.
class ProgressBar {
 public:
  explicit ProgressBar(long long total);
  ~ProgressBar();  // removes the bar
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Draws `done` of the total, at most ten times a second.
  void update(long long done);

 private:
  using Clock = std::chrono::steady_clock;

  long long total_;
  bool on_terminal_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point next_ = start_;
};

}  // namespace clothsim
