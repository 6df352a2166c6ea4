#pragma once

#include <geometry_msgs/Vector3Stamped.h>
#include <ros/node_handle.h>
#include <ros/subscriber.h>

#include <optional>

#include "clothsim/ros/changes.h"
#include "clothsim/ros/tf_frame.h"
#include "clothsim/ros/throttle.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// Sets the mean wind from ~wind, a velocity [m/s] in any tf frame: only the frame's orientation
/// counts, as it is when the message comes. An empty frame is the world's. What it takes stands in
/// ~changes. Logs what it refuses: a frame without a transform, numbers out of range.
class WindListener {
 public:
  /// All must outlive this.
  WindListener(ros::NodeHandle&, clothsim::Simulator&, TfListener&, Changes&);

  /// Tells ~changes of the wind that was heard last, where that still holds.
  void tell() const;

 private:
  void hear(const geometry_msgs::Vector3Stamped&);

  clothsim::Simulator& simulator_;
  TfListener& tf_;
  Changes& changes_;
  std::optional<clothsim::Vector3> heard_;  // last [m/s]
  Throttle warnings_{warning_period};
  ros::Subscriber subscriber_;
};

}  // namespace clothsim_ros
