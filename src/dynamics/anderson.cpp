#include "clothsim/dynamics/anderson.h"

#include <Eigen/QR>

namespace clothsim {

void Anderson::reset() {
  has_last_ = false;
  x_steps_.clear();
  change_steps_.clear();
}

void Anderson::next(const Points& change, Points& x) {
  if (has_last_) {
    x_steps_.push_back(x - last_x_);
    change_steps_.push_back(change - last_change_);
    if (static_cast<int>(x_steps_.size()) > window_) {
      x_steps_.pop_front();
      change_steps_.pop_front();
    }
  }
  last_x_ = x;
  last_change_ = change;
  has_last_ = true;

  // Weights by least squares: |change - sum of weight * change step| smallest.
  const auto count = static_cast<Eigen::Index>(change_steps_.size());
  Eigen::MatrixXd products(count, count);
  Eigen::VectorXd rhs(count);
  const auto dot = [](const Points& a, const Points& b) { return a.cwiseProduct(b).sum(); };
  for (Eigen::Index i = 0; i < count; ++i) {
    const Points& step = change_steps_[static_cast<std::size_t>(i)];
    rhs[i] = dot(step, change);
    for (Eigen::Index j = 0; j <= i; ++j) {
      products(i, j) = products(j, i) = dot(step, change_steps_[static_cast<std::size_t>(j)]);
    }
  }

  x += change;
  if (count == 0) return;
  const Eigen::VectorXd weights = products.colPivHouseholderQr().solve(rhs);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    x -= weights[i] * (x_steps_[k] + change_steps_[k]);
  }
}

}  // namespace clothsim
