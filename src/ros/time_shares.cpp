#include "clothsim/ros/time_shares.h"

#include <time.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <utility>

namespace clothsim_ros {
namespace {

double seconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

class TimedCallback : public ros::CallbackInterface {
 public:
  TimedCallback(ros::CallbackInterfacePtr callback, TimeShares& time)
      : callback_(std::move(callback)), time_(time) {}

  CallResult call() override {
    const TimeShares::Scope scope(time_, TimeShares::Use::serving);
    return callback_->call();
  }

  bool ready() override { return callback_->ready(); }

 private:
  ros::CallbackInterfacePtr callback_;
  TimeShares& time_;
};

}  // namespace

TimeShares::Scope::Scope(TimeShares& shares, Use use) : shares_(shares), outer_(shares.use_) {
  shares_.charge();
  shares_.use_ = use;
}

TimeShares::Scope::~Scope() {
  shares_.charge();
  shares_.use_ = outer_;
}

TimeShares::Seconds TimeShares::now() {
  return {seconds(CLOCK_MONOTONIC), seconds(CLOCK_THREAD_CPUTIME_ID)};
}

void TimeShares::charge() {
  const Seconds until = now();
  at(use_).wall += until.wall - charged_.wall;
  at(use_).cpu += until.cpu - charged_.cpu;
  charged_ = until;
}

TimeShares::Shares TimeShares::take() {
  charge();
  const double passed = charged_.wall - start_;
  const auto kept = [](const Seconds& spent) { return std::max(0.0, spent.wall - spent.cpu); };

  Shares shares;
  shares.serving = at(Use::serving).wall / passed;
  shares.simulating = at(Use::simulating).cpu / passed;
  shares.publishing = at(Use::publishing).cpu / passed;
  shares.kept = (kept(at(Use::simulating)) + kept(at(Use::publishing))) / passed;

  spent_ = {};
  start_ = charged_.wall;
  return shares;
}

void TimedCallbacks::addCallback(const ros::CallbackInterfacePtr& callback, std::uint64_t owner) {
  queue_.addCallback(boost::make_shared<TimedCallback>(callback, time_), owner);
}

}  // namespace clothsim_ros
