#pragma once

#include <console_bridge/console.h>
#include <ros/time.h>

#include <string>

#include "clothsim/ros/throttle.h"

namespace clothsim_ros {

/// At most one warning of transforms that are ignored in so long a time.
inline const ros::WallDuration warning_period(5);

/// Takes to the log what tf2 says of transforms that it refuses, while this lives. tf2 says it of
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
