#pragma once

#include <ros/message_event.h>
#include <ros/node_handle.h>
#include <tf2_msgs/TFMessage.h>

#include <functional>

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

}  // namespace clothsim_ros
