#pragma once

#include <optional>

namespace clothsim_ros {

/// Measures an amount per second, such as simulated time.
class RateMeter {
 public:
  /// Discards the amount before `now` [s], as after a pause.
  void restart(double now);

  void add(double amount) { sum_ += amount; }

  /// Amount per second since the last call; empty where too little time passed.
  std::optional<double> take(double now);

 private:
  double start_ = 0;  // [s]
  double sum_ = 0;    // since start_
};

}  // namespace clothsim_ros
