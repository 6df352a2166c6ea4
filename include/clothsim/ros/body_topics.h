#pragma once

#include <clothsim/AttachBody.h>
#include <clothsim/Bodies.h>
#include <clothsim/DetachBody.h>
#include <clothsim/SetBody.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/service_server.h>
#include <ros/time.h>
#include <tf2_msgs/TFMessage.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "clothsim/ros/changes.h"
#include "clothsim/ros/grasper.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// The rigid bodies of the scene: ~bodies, their tf frames, ~set_body, ~attach_body and
/// ~detach_body. A scene without bodies has none of these.
class BodyTopics {
 public:
  /// All arguments must outlive this. `redraw`: called when a body has been put elsewhere.
  BodyTopics(const ros::NodeHandle&, clothsim::Simulator&, Grasper&, Changes&,
             std::string world_frame, std::function<void()> redraw);

  /// Does the next frame need the forces of the cloth on bodies?
  bool asks_for_wrenches() const { return bodies_ && bodies_.getNumSubscribers() > 0; }

  /// Publishes the frame just simulated, number `step` since the scene's start.
  void publish(const ros::Time& stamp, std::uint64_t step);

  /// To be called when another scene is loaded.
  void follow_scene();

 private:
  /// A body: its collider and its tf frame.
  struct Body {
    int collider;
    std::string frame;
  };

  clothsim::Bodies message() const;
  tf2_msgs::TFMessage transforms() const;
  bool set_body(clothsim::SetBody::Request&, clothsim::SetBody::Response&);
  bool attach_body(clothsim::AttachBody::Request&, clothsim::AttachBody::Response&);
  bool detach_body(clothsim::DetachBody::Request&, clothsim::DetachBody::Response&);
  /// The collider of a body. Throws InvalidValue.
  int find(const std::string& name) const;

  ros::NodeHandle node_;
  clothsim::Simulator& simulator_;
  Grasper& grasper_;
  Changes& changes_;
  std::string world_frame_;
  std::function<void()> redraw_;
  std::vector<Body> all_;
  ros::Publisher bodies_;
  ros::Publisher tf_;
  std::vector<ros::ServiceServer> services_;
  ros::Time stamp_;
  std::uint64_t step_ = 0;
};

}  // namespace clothsim_ros
