#include "clothsim/ros/timed_callbacks.h"

#include <boost/make_shared.hpp>
#include <utility>

namespace clothsim_ros {
namespace {

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

void TimedCallbacks::addCallback(const ros::CallbackInterfacePtr& callback, std::uint64_t owner) {
  queue_.addCallback(boost::make_shared<TimedCallback>(callback, time_), owner);
}

}  // namespace clothsim_ros
