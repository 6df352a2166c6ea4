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

/// Tells on ~changes which calls and which tf frames changed how the simulation goes on, for bags.
class Changes {
 public:
  /// Pacer and `frame_number` must outlive this.
  Changes(ros::NodeHandle&, const Pacer&, const std::uint64_t& frame_number);

  /// Another scene: what of it no live value changes. A reset tells it, too.
  void set_scene(const std::string& fixed_values) { scene_ = fixed_values; }
  const std::string& scene() const { return scene_; }

  /// A call came. To be called before it changes the frame number. Adds what it is and when.
  void publish(const std::string& what, clothsim::Change = {});

  /// The next frame goes by the latest transform of `frame`, if there is one. Tells where that is
  /// another than at the last call; after a reset all are told. `what` is tf or target.
  void follow(const TfFrame& frame, const std::string& what = "tf");

 private:
  const Pacer& pacer_;
  const std::uint64_t& frame_number_;
  ros::Publisher publisher_;
  std::string scene_;
  std::map<std::string, geometry_msgs::Transform> told_;  // by frame
};

}  // namespace clothsim_ros
