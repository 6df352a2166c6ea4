#pragma once

#include <clothsim/PointForces.h>
#include <ros/node_handle.h>
#include <ros/subscriber.h>

#include <limits>

#include "clothsim/ros/changes.h"
#include "clothsim/ros/rates.h"
#include "clothsim/ros/tf_frame.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// Sets forces on points from ~forces, in the axes of any tf frame at the time of arrival. Accepted
/// messages are published on ~changes, refused ones are logged: a frame without a transform,
/// invalid points, numbers out of range.
class ForceListener {
 public:
  /// All must outlive this.
  ForceListener(ros::NodeHandle&, clothsim::Simulator&, TfListener&, Changes&);

  /// Ends forces whose time is over: to be called before each frame.
  void end_when_due();

 private:
  void hear(const clothsim::PointForces&);
  void refuse(const std::string& why);

  clothsim::Simulator& simulator_;
  TfListener& tf_;
  Changes& changes_;
  double end_ = std::numeric_limits<double>::infinity();  // simulated time [s]
  Throttle warnings_{warning_period};
  ros::Subscriber subscriber_;
};

}  // namespace clothsim_ros
