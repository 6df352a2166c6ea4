#include "clothsim/ros/tf_subscribers.h"

#include <ros/console.h>

namespace clothsim_ros {
namespace {

/// As many as tf2's own listener keeps.
constexpr std::uint32_t tf_input_queue = 100;

}  // namespace

void TfSubscribers::listen(ros::NodeHandle& node, const Hear& hear) {
  const auto subscribe = [&](const std::string& topic, bool is_static) {
    const boost::function<void(const Event&)> callback = [hear, is_static](const Event& event) {
      hear(event, is_static);
    };
    return node.subscribe<tf2_msgs::TFMessage>(topic, tf_input_queue, callback);
  };
  moving_ = subscribe("/tf", false);
  static_ = subscribe("/tf_static", true);
}

Tf2Log::Tf2Log() { console_bridge::useOutputHandler(this); }

Tf2Log::~Tf2Log() { console_bridge::restorePreviousOutputHandler(); }

void Tf2Log::log(const std::string& text, console_bridge::LogLevel, const char*, int) {
  if (warnings_.passes()) ROS_WARN("%s", text.c_str());
}

}  // namespace clothsim_ros
