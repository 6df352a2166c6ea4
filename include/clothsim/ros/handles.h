#pragma once

#include <clothsim/Change.h>
#include <clothsim/ClothTopology.h>
#include <interactive_markers/interactive_marker_server.h>
#include <ros/node_handle.h>
#include <tf2_ros/transform_broadcaster.h>

#include <map>
#include <string>

#include "clothsim/ros/other_broadcasters.h"
#include "clothsim/shapes/collider.h"

namespace clothsim_ros {

/// Interactive markers that move and rotate the tf frames of a clothsim node's colliders, one for
/// each frame. A frame is broadcast repeatedly from the first click on its handle, also while time
/// stands still. While another node broadcasts the frame, it has no handle.
class Handles {
 public:
  /// `cloth`: the namespace of the clothsim node. Adapts when that node loads another scene.
  explicit Handles(const ros::NodeHandle& cloth);

 private:
  struct Handle {
    clothsim::Pose pose;  // of the frame in the world
    double size = 1;      // [m]
    bool shown = false;
  };

  void hear_topology(const ros::MessageEvent<const clothsim::ClothTopology>&);
  void read_scene();
  void show_or_hide();
  void show(const std::string& frame, Handle&);
  void drag(const visualization_msgs::InteractiveMarkerFeedback&);
  void broadcast(const std::string& frame, const clothsim::Pose&);

  ros::NodeHandle cloth_;
  std::string world_frame_;
  std::map<std::string, Handle> handles_;          // by frame
  std::map<std::string, clothsim::Pose> dragged_;  // frames that are broadcast
  OtherBroadcasters others_;
  tf2_ros::TransformBroadcaster broadcaster_;
  interactive_markers::InteractiveMarkerServer server_;
  boost::shared_ptr<ros::M_string> connection_;  // of the last topology
  ros::Subscriber topology_subscriber_;
  ros::Subscriber changes_subscriber_;
  ros::WallTimer timer_;
};

}  // namespace clothsim_ros
