#pragma once

#include <cmath>

namespace clothsim {

/// Nesterov's momentum for passes over constraints: how far the next pass starts beyond the last
/// one, of what that changed. It starts over where it leads uphill (O'Donoghue & Candes 2015,
/// "Adaptive restart for accelerated gradient schemes"; on contact Mazhar et al. 2015).
class Momentum {
 public:
  /// `strength`: what another problem, much like this one, ended with, where it is to go on. The
  /// first pass has none.
  explicit Momentum(double strength = 1) : theta_(strength) {}

  double share() const { return share_; }

  /// 1 at first, and about 1/2 more with each pass.
  double strength() const { return theta_; }

  /// After a pass whose changes have that `descent`, see PassChange.
  void next(double descent) {
    if (descent < 0) theta_ = 1;
    const double after = (1 + std::sqrt(1 + 4 * theta_ * theta_)) / 2;
    share_ = (theta_ - 1) / after;
    theta_ = after;
  }

 private:
  double theta_;
  double share_ = 0;
};

}  // namespace clothsim
