#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "clothsim/model/types.h"

namespace clothsim::test {

/// Draws random numbers; equal seeds give equal sequences.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed) {}

  double even(double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(engine_);
  }

  /// Log-uniform: each decade is equally likely.
  double decades(double from, double to) { return from * std::pow(to / from, even(0, 1)); }

  /// Includes both ends.
  int whole(int from, int to) { return std::uniform_int_distribution<int>(from, to)(engine_); }

  bool happens(double probability) { return even(0, 1) < probability; }

  template <typename T>
  const T& one_of(const std::vector<T>& values) {
    return values[static_cast<std::size_t>(whole(0, static_cast<int>(values.size()) - 1))];
  }

  Vector3 in_box(const Vector3& from, const Vector3& to) {
    const double x = even(from.x(), to.x()), y = even(from.y(), to.y());
    return {x, y, even(from.z(), to.z())};
  }

  Vector3 direction() {
    Vector3 v;
    do {
      v = in_box(Vector3::Constant(-1), Vector3::Constant(1));
    } while (v.norm() > 1 || v.norm() < 0.1);
    return v.normalized();
  }

  Eigen::Quaterniond orientation() {
    const Vector3 axis = direction();
    return Eigen::Quaterniond(Eigen::AngleAxisd(even(-M_PI, M_PI), axis));
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace clothsim::test
