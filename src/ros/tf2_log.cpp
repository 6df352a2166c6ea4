#include "clothsim/ros/tf2_log.h"

#include <ros/console.h>

namespace clothsim_ros {

Tf2Log::Tf2Log() { console_bridge::useOutputHandler(this); }

Tf2Log::~Tf2Log() { console_bridge::restorePreviousOutputHandler(); }

void Tf2Log::log(const std::string& text, console_bridge::LogLevel, const char*, int) {
  if (warnings_.passes()) ROS_WARN("%s", text.c_str());
}

}  // namespace clothsim_ros
