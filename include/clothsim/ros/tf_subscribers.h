#pragma once

#include <console_bridge/console.h>
#include <ros/message_event.h>
#include <ros/node_handle.h>
#include <ros/time.h>
#include <tf2_msgs/TFMessage.h>

#include <functional>
#include <string>

#include "clothsim/ros/rates.h"

namespace clothsim_ros {

/// Subscribes to /tf and /tf_static, with the sender of each message: tf2's own listener puts all
/// transforms into its buffer.
class TfSubscribers {
 public:
  using Event = ros::MessageEvent<const tf2_msgs::TFMessage>;
  using Hear = std::function<void(const Event&, bool is_static)>;

  void listen(ros::NodeHandle&, const Hear&);

 private:
  ros::Subscriber moving_;
  ros::Subscriber static_;
};

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
