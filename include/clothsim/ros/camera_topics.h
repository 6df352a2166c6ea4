#pragma once

#include <image_transport/image_transport.h>
#include <ros/node_handle.h>

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "clothsim/render/renderer.h"

namespace clothsim_ros {

/// The topics of a camera, below its name: color, depth, mask, uv, normals and flow, each with
/// image_raw, by image_transport, and camera_info; and visible_points.
class CameraTopics {
 public:
  /// `subscriber_came` runs among the node's other callbacks.
  CameraTopics(const ros::NodeHandle&, const std::string& camera,
               const std::function<void()>& subscriber_came);

  /// The images with subscribers.
  clothsim::WantedImages wanted() const;

  /// Whether any of the topics has a subscriber.
  bool subscribed() const;

  /// Publishes the images and points that are given, and all camera_infos, with one header. From
  /// any thread.
  void publish(const std_msgs::Header&, unsigned topology_seq, const clothsim::Camera&,
               const clothsim::Images&) const;

 private:
  struct Topic {
    image_transport::Publisher image;
    ros::Publisher info;
  };

  template <class Value>
  void send(const Topic&, const std_msgs::Header&, const std::string& encoding,
            const clothsim::Images&, const std::vector<Value>& pixels) const;

  image_transport::ImageTransport transport_;
  std::array<Topic, 6> topics_;  // colour, depth, mask, uv, normals, flow
  ros::Publisher visible_points_;
};

}  // namespace clothsim_ros
