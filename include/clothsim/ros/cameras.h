#pragma once

#include <tf2_ros/static_transform_broadcaster.h>

#include <functional>
#include <list>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/ros/photographer.h"

namespace clothsim_ros {

/// The cameras of a node: at least one, the first that of ~camera. They may stand anywhere, and
/// share light and looks. Member functions are those of Photographer, for all cameras.
class Cameras {
 public:
  /// As Photographer's constructor. Throws std::runtime_error with the name of a parameter for a
  /// view that cannot be drawn.
  Cameras(const ros::NodeHandle&, const std::vector<clothsim::NamedView>&,
          const clothsim::Simulator&, TfListener& tf, const std::vector<std::string>& image_folders,
          const ros::Time& now);

  std::vector<std::string> names() const;

  /// The views that were set last, by camera.
  std::vector<clothsim::View> views() const;

  /// Sets a view for each camera. Throws InvalidValue and keeps the old views when one is refused.
  void set_views(const std::vector<clothsim::View>&);

  /// Changes the view of one camera.
  void change_view(const std::string& name, const std::function<void(clothsim::View&)>& change);

  /// Changes light or looks, for all cameras.
  void change_looks(const std::function<void(clothsim::View&)>& change);

  void update(const ros::Time& stamp);
  void wait();
  void finish();
  void refresh(bool paused);
  void redraw();
  std::vector<CameraStatus> status();

 private:
  void broadcast(const geometry_msgs::TransformStamped&);

  /// One for all cameras: with several in a node, late subscribers would get only the last
  /// transform.
  std::optional<tf2_ros::StaticTransformBroadcaster> broadcaster_;
  std::list<Photographer> cameras_;
};

}  // namespace clothsim_ros
