#include "clothsim/ros/signals.h"

#include <ros/init.h>

#include <csignal>

namespace clothsim_ros {

void shut_down_on_sigterm() {
  std::signal(SIGTERM, [](int) { ros::requestShutdown(); });
}

}  // namespace clothsim_ros
