#include <gtest/gtest.h>
#include <ros/callback_queue.h>

#include <boost/make_shared.hpp>
#include <chrono>
#include <thread>

#include "clothsim/ros/time_shares.h"

namespace clothsim_ros::timed_callbacks_test {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds nap(30);

/// Sleeps, so it takes time but no CPU, as a callback that waits for an answer.
class Sleeper : public ros::CallbackInterface {
 public:
  CallResult call() override {
    std::this_thread::sleep_for(nap);
    return Success;
  }
};

/// Share of the time from `begin` to now that a nap takes at least.
double share_of_a_nap(Clock::time_point begin) {
  return std::chrono::duration<double>(nap) / std::chrono::duration<double>(Clock::now() - begin);
}

struct Served : testing::Test {
  ros::CallbackQueue queue;
  const Clock::time_point begin = Clock::now();
  TimeShares time;
  TimedCallbacks callbacks{queue, time};
};

// A callback that comes while callOne() waits counts as time of a call, not of waiting.
TEST_F(Served, CountsACallbackThatIsWaitedFor) {
  callbacks.addCallback(boost::make_shared<Sleeper>(), 0);
  EXPECT_EQ(queue.callOne(ros::WallDuration(10)), ros::CallbackQueue::Called);
  EXPECT_GE(time.take().serving, share_of_a_nap(begin));
}

TEST_F(Served, DoesNotCountWaiting) {
  EXPECT_EQ(queue.callOne(ros::WallDuration(0.03)), ros::CallbackQueue::Empty);
  EXPECT_EQ(time.take().serving, 0);
}

TEST_F(Served, CountsSimulatingInACallbackAsThat) {
  struct Stepper : Sleeper {
    explicit Stepper(TimeShares& shares) : time(shares) {}
    CallResult call() override {
      const TimeShares::Scope scope(time, TimeShares::Use::simulating);
      return Sleeper::call();
    }
    TimeShares& time;
  };
  callbacks.addCallback(boost::make_shared<Stepper>(time), 0);
  queue.callAvailable();
  const TimeShares::Shares shares = time.take();
  EXPECT_GE(shares.kept, share_of_a_nap(begin) / 2);  // asleep: not its own CPU time
  EXPECT_LT(shares.serving, shares.kept);
}

TEST_F(Served, ForgetsThoseOfAnOwnerThatGoes) {
  callbacks.addCallback(boost::make_shared<Sleeper>(), 7);
  callbacks.removeByID(7);
  EXPECT_TRUE(queue.isEmpty());
}

}  // namespace
}  // namespace clothsim_ros::timed_callbacks_test
