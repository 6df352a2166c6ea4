#include "clothsim/ros/cpu_shares.h"

#include <time.h>

namespace clothsim_ros {
namespace {

/// CPU time of this thread [s].
double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

CpuShares::Scope::Scope(CpuShares& shares, Use use) : shares_(shares), outer_(shares.use_) {
  shares_.charge();
  shares_.use_ = use;
}

CpuShares::Scope::~Scope() {
  shares_.charge();
  shares_.use_ = outer_;
}

void CpuShares::charge() {
  const double now = cpu_seconds();
  seconds_[static_cast<size_t>(use_)] += now - charged_;
  charged_ = now;
}

std::array<double, 3> CpuShares::take() {
  charge();
  const ros::SteadyTime now = ros::SteadyTime::now();
  const double passed = (now - start_).toSec();
  std::array<double, 3> shares{};
  for (size_t i = 0; i < shares.size(); ++i) shares[i] = seconds_[i] / passed;
  seconds_ = {};
  start_ = now;
  return shares;
}

}  // namespace clothsim_ros
