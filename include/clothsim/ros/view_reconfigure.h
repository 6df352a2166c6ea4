#pragma once

#include <ros/node_handle.h>

#include <memory>
#include <string>
#include <vector>

#include "clothsim/ros/cameras.h"
#include "clothsim/scene/scene.h"

namespace clothsim_ros {

/// The view that dynamic_reconfigure changes: ~shading/cloth, ~shading/NAME for each collider and
/// ~light, which all cameras share; ~viewpoint of ~camera, ~camera_NAME/viewpoint of others.
/// Changes take effect with the next picture. They have a thread of their own, so that the
/// simulation does not wait while images are read.
class ViewReconfigure {
 public:
  /// Starts from the cameras' views. The cameras must outlive this.
  ViewReconfigure(const ros::NodeHandle&, Cameras&, const clothsim::Scene&);
  ~ViewReconfigure();

  /// The names of the values, below the node's, such as "light/intensity".
  const std::vector<std::string>& names() const;

  /// The values that differ from the start's, as "light/intensity 3".
  std::vector<std::string> changed();

  /// Undoes the changes of requests; may read images. Throws the exceptions of the cameras.
  void reset();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace clothsim_ros
