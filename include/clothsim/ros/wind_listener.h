#pragma once

#include <geometry_msgs/Vector3Stamped.h>
#include <ros/node_handle.h>
#include <ros/subscriber.h>

#include <optional>

#include "clothsim/ros/changes.h"
#include "clothsim/ros/rates.h"
#include "clothsim/ros/tf_frame.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// Sets the mean wind from ~wind, a velocity [m/s] in any tf frame: only the frame's orientation at
/// the time of arrival counts. An empty frame is the world's. Accepted messages are published on
/// ~changes, refused ones are logged: a frame without a transform, numbers out of range.
class WindListener {
 public:
  /// All must outlive this.
  WindListener(ros::NodeHandle&, clothsim::Simulator&, TfListener&, Changes&);

  /// Publishes the last wind received on ~changes, where it is still in effect.
  void tell() const;

 private:
  void hear(const geometry_msgs::Vector3Stamped&);

  clothsim::Simulator& simulator_;
  TfListener& tf_;
  Changes& changes_;
  std::optional<clothsim::Vector3> heard_;  // the last one received [m/s]
  Throttle warnings_{warning_period};
  ros::Subscriber subscriber_;
};

}  // namespace clothsim_ros
