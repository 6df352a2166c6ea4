#pragma once

#include <clothsim/Change.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <cstdint>
#include <map>
#include <string>

#include "clothsim/ros/pacer.h"
#include "clothsim/ros/tf_frame.h"

namespace clothsim_ros {

/// Publishes on ~changes each call and tf frame that affects the simulation, for bags.
class Changes {
 public:
  /// Pacer and `frame_number` must outlive this.
  Changes(ros::NodeHandle&, const Pacer&, const std::uint64_t& frame_number);

  /// To be called for another scene: its values that are not live. A reset publishes them, too.
  void set_scene(const std::string& fixed_values) { scene_ = fixed_values; }
  const std::string& scene() const { return scene_; }

  /// Publishes a call, with its name and time. To be called before the call changes the frame
  /// number.
  void publish(const std::string& what, clothsim::Change = {});

  /// The next frame uses the latest transform of `frame`, if there is one. Publishes it where it
  /// differs from that of the last call; after a reset always. `what`: "tf" or "target".
  void follow(const TfFrame& frame, const std::string& what = "tf");

 private:
  const Pacer& pacer_;
  const std::uint64_t& frame_number_;
  ros::Publisher publisher_;
  std::string scene_;
  std::map<std::string, geometry_msgs::Transform> told_;  // by frame
};

}  // namespace clothsim_ros
