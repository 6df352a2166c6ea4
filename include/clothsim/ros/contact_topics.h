#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/time.h>

#include <cstdint>
#include <string>
#include <vector>

#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// Contact forces of the cloth on colliders, on ~contacts and ~contact_wrench/COLLIDER. Without a
/// subscriber, frames do not sum them up.
class ContactTopics {
 public:
  /// The simulator must outlive this.
  ContactTopics(const ros::NodeHandle&, clothsim::Simulator&, std::string world_frame);

  /// To be called before each frame. `others_ask`: whether others need the forces in it, too.
  void ask(bool others_ask);

  /// Publishes the frame just simulated, number `step` since the scene's start.
  void publish(const ros::Time& stamp, std::uint64_t step);

  /// To be called when another scene is loaded.
  void follow_scene();

 private:
  /// The topic of a collider's wrench.
  struct WrenchTopic {
    std::size_t collider;
    ros::Publisher publisher;
  };

  ros::NodeHandle node_;
  clothsim::Simulator& simulator_;
  std::string world_frame_;
  ros::Publisher contacts_;
  std::vector<WrenchTopic> wrenches_;
  bool asked_ = false;  // in the frame in progress
};

}  // namespace clothsim_ros
