#include "clothsim/constraints/sleep_bounds.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace clothsim {
namespace {

/// Compares bits, which is far faster than to measure.
bool are_same(const Points& a, const Points& b) {
  const auto bytes = static_cast<std::size_t>(a.size()) * sizeof(double);
  return a.rows() == b.rows() && std::memcmp(a.data(), b.data(), bytes) == 0;
}

/// Angle between two orientations [rad].
double angle_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  const Eigen::Quaterniond turn = b * a.conjugate();
  return 2 * std::atan2(turn.vec().norm(), std::abs(turn.w()));
}

}  // namespace

double MotionBound::since_step(const Points& start) const {
  if (seen_.rows() != start.rows()) return infinity;
  return are_same(seen_, start) ? 0 : longest_displacement(seen_, start);
}

void MotionBound::begin(const Points& start, const Points& now) {
  between_steps_ = since_step(start);
  at_start_ = total_ + (between_steps_ < infinity ? between_steps_ : 0);
  update(start, now);
}

void MotionBound::update(const Points& start, const Points& now) {
  in_step_ = longest_displacement(start, now);
  total_ = at_start_ + in_step_;
}

void SleepBounds::reset(int blocks) {
  used_up_at_.assign(static_cast<std::size_t>(blocks), -infinity);
  min_used_up_at_ = -infinity;
  moved_ = 0;
  is_seen_ = false;
}

double SleepBounds::follow(const Pose& pose, double radius) {
  double moved = infinity;
  if (is_seen_) {
    moved = (pose.position - pose_.position).norm();
    if (pose.orientation.coeffs() != pose_.orientation.coeffs()) {
      moved += radius * angle_between(pose_.orientation, pose.orientation);
    }
    moved_ += moved;
  }
  is_seen_ = true;
  pose_ = pose;
  return moved;
}

void SleepBounds::find_near(double travelled, double distance, std::vector<Span>& spans) {
  spans.clear();
  if (!is_near(travelled, distance)) return;
  const double limit = travelled + moved_ + distance;
  min_used_up_at_ = infinity;
  for (int b = 0; b < static_cast<int>(used_up_at_.size()); ++b) {
    const double at = used_up_at_[static_cast<std::size_t>(b)];
    min_used_up_at_ = std::min(min_used_up_at_, at);
    if (at > limit) continue;
    const bool follows =
        !spans.empty() && spans.back().end == b && b - spans.back().begin < Span::longest;
    if (follows) {
      ++spans.back().end;
    } else {
      spans.push_back({b, b + 1});
    }
  }
}

}  // namespace clothsim
