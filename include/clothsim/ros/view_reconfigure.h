#pragma once

#include <ros/node_handle.h>

#include <memory>
#include <string>
#include <vector>

#include "clothsim/ros/cameras.h"
#include "clothsim/scene/scene.h"

namespace clothsim_ros {

/// The view that dynamic_reconfigure changes: ~shading/cloth, ~shading/NAME for each collider
/// and ~light, which all cameras see; ~viewpoint of ~camera, ~camera_NAME/viewpoint of others.
/// Changes hold from the next picture on. A thread of its own serves them, so that the simulation
/// does not wait while images are read.
class ViewReconfigure {
 public:
  /// Starts from the cameras' views. The cameras must outlive this.
  ViewReconfigure(const ros::NodeHandle&, Cameras&, const clothsim::Scene&);
  ~ViewReconfigure();

  /// Of the values, below the node's, such as "light/intensity".
  const std::vector<std::string>& names() const;

  /// Those that differ from the start's, as "light/intensity 3".
  std::vector<std::string> changed();

  /// Takes back what requests have changed; may read images. Throws what the cameras throw.
  void reset();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace clothsim_ros
