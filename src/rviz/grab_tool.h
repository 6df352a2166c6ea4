#pragma once

#include <rviz/tool.h>
#include <tf2_ros/transform_broadcaster.h>

#include <memory>
#include <optional>
#include <string>

#include "call_queue.h"
#include "cloth_display.h"
#include "clothsim/model/types.h"

namespace rviz {
class FloatProperty;
}

namespace clothsim_rviz {

/// Grabs the cloth under the mouse, of all cloths that ClothDisplays show: the points near it are
/// attached to a tf frame of this tool, which follows the mouse until the button is released.
class GrabTool : public rviz::Tool {
  Q_OBJECT

 public:
  GrabTool();
  ~GrabTool() override;

  void activate() override {}
  void deactivate() override { release(); }
  void update(float wall_dt, float ros_dt) override;
  int processMouseEvent(rviz::ViewportMouseEvent&) override;

 protected:
  void onInitialize() override;

 private:
  struct Ray {
    clothsim::Vector3 origin;     // [m]
    clothsim::Vector3 direction;  // unit length
    clothsim::Vector3 ahead;      // unit vector along the camera's view
  };
  /// A grab, in the cloth's world frame.
  struct Hold {
    std::string node;
    std::string world_frame;
    clothsim::Pose in_fixed;         // of the world frame in RViz's fixed frame
    clothsim::Vector3 place;         // of the tool's frame [m]
    std::shared_ptr<bool> attached;  // the node has confirmed it
  };

  /// The ray under the mouse, in a frame at `in_fixed` in RViz's fixed frame.
  static Ray ray_of(const rviz::ViewportMouseEvent&, const clothsim::Pose& in_fixed);
  void grab(const rviz::ViewportMouseEvent&);
  void attach(const Hold&, const std::vector<std::int32_t>& points);
  void drag(const rviz::ViewportMouseEvent&);
  void push(const rviz::ViewportMouseEvent&);
  void release();
  void broadcast();

  rviz::FloatProperty* radius_;
  rviz::FloatProperty* tear_force_;
  std::string frame_;
  std::optional<Hold> hold_;
  ros::Time stamp_;  // of the last transform
  std::unique_ptr<tf2_ros::TransformBroadcaster> broadcaster_;
  CallQueue calls_;
};

}  // namespace clothsim_rviz
