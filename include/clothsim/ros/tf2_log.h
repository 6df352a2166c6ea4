#pragma once

#include <console_bridge/console.h>
#include <ros/time.h>

#include <string>

#include "clothsim/ros/throttle.h"

namespace clothsim_ros {

/// Least time between two warnings of ignored transforms.
inline const ros::WallDuration warning_period(5);

/// While it exists, tf2's messages on transforms that it refuses go to the log. tf2 has one for
/// each, and a message may hold a hundred thousand.
class Tf2Log : public console_bridge::OutputHandler {
 public:
  Tf2Log();
  ~Tf2Log() override;
  Tf2Log(const Tf2Log&) = delete;
  Tf2Log& operator=(const Tf2Log&) = delete;

 private:
  void log(const std::string& text, console_bridge::LogLevel, const char* file, int line) override;

  Throttle warnings_{warning_period};
};

}  // namespace clothsim_ros
