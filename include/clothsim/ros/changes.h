#pragma once

#include <clothsim/Change.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <cstdint>
#include <string>

#include "clothsim/ros/pacer.h"

namespace clothsim_ros {

/// Tells on ~changes which calls changed how the simulation goes on, for bags.
class Changes {
 public:
  /// Pacer and `frame_number` must outlive this.
  Changes(ros::NodeHandle&, const Pacer&, const std::uint64_t& frame_number);

  /// To be called before a call has changed the frame number. Adds when that is.
  void publish(const std::string& service, clothsim::Change = {});

 private:
  const Pacer& pacer_;
  const std::uint64_t& frame_number_;
  ros::Publisher publisher_;
};

}  // namespace clothsim_ros
