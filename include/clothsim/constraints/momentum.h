#pragma once

#include <cmath>

namespace clothsim {

/// Nesterov's momentum for passes over constraints: each pass starts from the result of the last
/// one, extrapolated by share() of its change. It restarts where it leads uphill (O'Donoghue &
/// Candes 2015, "Adaptive restart for accelerated gradient schemes"; on contact Mazhar et al.
/// 2015).
class Momentum {
 public:
  /// `strength`: the final one of a similar problem, to continue with it. The first pass has no
  /// momentum.
  explicit Momentum(double strength = 1) : theta_(strength) {}

  double share() const { return share_; }

  /// 1 at first, and about 1/2 more with each pass.
  double strength() const { return theta_; }

  /// To be called after a pass, with its `descent`, see PassChange.
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
