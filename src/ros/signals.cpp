#include "clothsim/ros/signals.h"

#include <pthread.h>
#include <ros/init.h>

#include <atomic>
#include <csignal>
#include <thread>

namespace clothsim_ros {
namespace {

std::atomic<bool> interrupted{false};
std::atomic<bool> ends_in_order{false};

void take(const sigset_t& signals) {
  int signal = 0;
  while (sigwait(&signals, &signal) == 0) {
    const bool again = interrupted.exchange(true);
    if (again || !ends_in_order) ros::requestShutdown();
  }
}

}  // namespace

void shut_down_on_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);  // also for later threads
  std::thread(take, signals).detach();
}

void end_in_order_on_signals() { ends_in_order = true; }

bool is_interrupted() { return interrupted; }

}  // namespace clothsim_ros
