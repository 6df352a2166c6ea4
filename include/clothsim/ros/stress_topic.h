#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/time.h>

#include <cstdint>
#include <string>

#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// The stress in the cloth, on ~stress. Without a subscriber nothing is computed.
class StressTopic {
 public:
  /// The simulator must outlive this.
  StressTopic(ros::NodeHandle&, const clothsim::Simulator&, std::string world_frame);

  /// Publishes the stress after the frame just simulated, number `step` since the scene's start.
  void publish(const ros::Time& stamp, std::uint64_t step) const;

 private:
  const clothsim::Simulator& simulator_;
  std::string world_frame_;
  ros::Publisher publisher_;
};

}  // namespace clothsim_ros
