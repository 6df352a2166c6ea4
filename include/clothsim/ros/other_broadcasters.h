#pragma once

#include <ros/node_handle.h>
#include <rosgraph_msgs/Clock.h>
#include <tf2/buffer_core.h>

#include <map>
#include <optional>
#include <string>

#include "clothsim/ros/tf_subscribers.h"
#include "clothsim/shapes/collider.h"

namespace clothsim_ros {

/// The tf frames that other nodes broadcast, and their poses. Stores only the latest transform of
/// each frame, independent of its stamp: time may stand still or run backwards.
class OtherBroadcasters {
 public:
  explicit OtherBroadcasters(ros::NodeHandle&);

  /// The node that broadcasts the frame; empty: none, or it has been silent for a second. A static
  /// transform stays valid.
  std::string of(const std::string& frame) const;

  /// Pose of the frame in the world; empty where no other node has sent it.
  std::optional<clothsim::Pose> pose(const std::string& world, const std::string& frame) const;

  /// A stamp for a transform of the frame: now, in the other nodes' time, and later than all other
  /// stamps, as subscribers drop older transforms.
  ros::Time next_stamp(const std::string& frame);

 private:
  struct Heard {
    std::string node;
    ros::SteadyTime when;
    bool is_static = false;
  };

  void hear(const TfSubscribers::Event&, bool is_static);
  void tick(const ros::Time& clock);

  const bool sim_time_;  // other nodes use /clock
  ros::Time clock_;
  tf2::BufferCore buffer_;
  Tf2Log log_;
  std::map<std::string, Heard> heard_;       // by frame
  std::map<std::string, ros::Time> newest_;  // stamp by frame
  TfSubscribers subscribers_;
  ros::Subscriber clock_subscriber_;
};

}  // namespace clothsim_ros
