#include "clothsim/ros/handles.h"

#include <ros/console.h>

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "clothsim/model/errors.h"
#include "clothsim/ros/conversions.h"
#include "clothsim/ros/scene_parameter.h"
#include "clothsim/ros/tf_frame.h"

namespace clothsim_ros {
namespace {

using visualization_msgs::InteractiveMarker;
using visualization_msgs::InteractiveMarkerControl;
using visualization_msgs::InteractiveMarkerFeedback;

constexpr std::uint32_t handles_queue = 1;

/// Moving tf frames are changes, too: enough for a moment of them.
constexpr std::uint32_t changes_queue = 1000;

/// How often to check whether another node broadcasts a frame or stopped to, and to send the
/// dragged frames again.
const ros::WallDuration period(0.1);

/// Size of a handle, larger than its collider; an unbounded collider has a fixed size [m].
constexpr double size_share = 2.5;  // of the collider's radius
constexpr double unbounded_size = 0.5;

double handle_size(const clothsim::Shape& shape) {
  const double radius = clothsim::bounding_radius(shape);
  return std::isfinite(radius) ? size_share * radius : unbounded_size;
}

/// An arrow along and a ring about each axis of the frame.
std::vector<InteractiveMarkerControl> make_controls() {
  // A control acts along its own x axis, which is turned to x, y and z.
  const std::array<std::pair<const char*, Eigen::Quaterniond>, 3> axes = {
      {{"x", {1, 0, 0, 0}},
       {"y", Eigen::Quaterniond(1, 0, 0, 1).normalized()},
       {"z", Eigen::Quaterniond(1, 0, -1, 0).normalized()}}};
  std::vector<InteractiveMarkerControl> controls;
  for (const auto& [axis, turn] : axes) {
    InteractiveMarkerControl control;
    control.orientation = to_quaternion_msg(turn);
    control.name = std::string("move_") + axis;
    control.interaction_mode = InteractiveMarkerControl::MOVE_AXIS;
    controls.push_back(control);
    control.name = std::string("rotate_") + axis;
    control.interaction_mode = InteractiveMarkerControl::ROTATE_AXIS;
    controls.push_back(control);
  }
  return controls;
}

}  // namespace

Handles::Handles(const ros::NodeHandle& cloth)
    : cloth_(cloth), others_(cloth_), server_(cloth.getNamespace() + "/handles") {
  topology_subscriber_ = cloth_.subscribe<clothsim::ClothTopology>(
      "topology", handles_queue,
      boost::function<void(const ros::MessageEvent<const clothsim::ClothTopology>&)>(
          [this](const auto& event) { hear_topology(event); }));
  changes_subscriber_ =
      cloth_.subscribe<clothsim::Change>("changes", changes_queue, [this](const auto& change) {
        if (change->what == "load_scene") read_scene();
      });
  timer_ = cloth_.createWallTimer(period, [this](const auto&) {
    show_or_hide();
    for (const auto& [frame, pose] : dragged_) broadcast(frame, pose);
  });
}

void Handles::hear_topology(const ros::MessageEvent<const clothsim::ClothTopology>& event) {
  // Only a connection's first topology means a new node or scene here. Later ones come when springs
  // are switched, too, and ~scene may then hold a scene that is not loaded.
  if (event.getConnectionHeaderPtr() == connection_) return;
  connection_ = event.getConnectionHeaderPtr();
  world_frame_ = event.getMessage()->header.frame_id;
  read_scene();
}

void Handles::read_scene() {
  clothsim::Scene scene;
  try {
    scene = read_scene_parameter(cloth_).scene;
  } catch (const clothsim::InvalidValue& error) {
    ROS_WARN("%s", error.message(cloth_.getNamespace() + "/", "/").c_str());
    return;
  }

  handles_.clear();
  server_.clear();
  for (const clothsim::ColliderSpec& collider : scene.colliders) {
    if (collider.frame.empty()) continue;
    Handle handle{collider.pose, handle_size(collider.shape), false};
    const auto dragged = dragged_.find(collider.frame);
    if (dragged != dragged_.end()) handle.pose = dragged->second;
    handles_[collider.frame] = handle;
  }
  show_or_hide();
}

void Handles::show_or_hide() {
  for (auto& [frame, handle] : handles_) {
    const std::string other = others_.of(frame);
    if (handle.shown && !other.empty()) {
      ROS_INFO("No handle on frame %s: %s broadcasts it", frame.c_str(), other.c_str());
      server_.erase(frame);
      handle.shown = false;
      dragged_.erase(frame);
    } else if (!handle.shown && other.empty()) {
      if (dragged_.count(frame) == 0) {
        handle.pose = others_.pose(world_frame_, frame).value_or(handle.pose);
      }
      show(frame, handle);
    }
  }
  server_.applyChanges();  // without effect where there are none
}

void Handles::show(const std::string& frame, Handle& handle) {
  InteractiveMarker marker;
  marker.header.frame_id = world_frame_;
  marker.name = frame;
  marker.description = frame;
  marker.scale = static_cast<float>(handle.size);
  marker.pose = to_pose_msg(handle.pose);
  marker.controls = make_controls();
  server_.insert(marker, [this](const auto& feedback) { drag(*feedback); });
  handle.shown = true;
}

void Handles::drag(const InteractiveMarkerFeedback& feedback) {
  // Place the collider at the first click, so that it moves from there.
  const bool moves = feedback.event_type == InteractiveMarkerFeedback::MOUSE_DOWN ||
                     feedback.event_type == InteractiveMarkerFeedback::POSE_UPDATE;
  const auto found = handles_.find(feedback.marker_name);
  if (!moves || found == handles_.end() || !found->second.shown) return;
  auto& [frame, handle] = *found;

  const clothsim::Pose pose = to_pose(feedback.pose);
  const bool in_world = feedback.header.frame_id == world_frame_;
  if (in_world && is_usable(pose)) {
    handle.pose = pose;
    dragged_[frame] = pose;
    broadcast(frame, pose);
  } else {
    ROS_WARN(
        "Ignored where the handle of frame %s was dragged: not finite, beyond %g m or not in %s",
        frame.c_str(), largest_coordinate, world_frame_.c_str());
    server_.setPose(frame, to_pose_msg(handle.pose));
  }
  server_.applyChanges();
}

void Handles::broadcast(const std::string& frame, const clothsim::Pose& pose) {
  geometry_msgs::TransformStamped msg;
  msg.header.stamp = others_.next_stamp(frame);
  msg.header.frame_id = world_frame_;
  msg.child_frame_id = frame;
  msg.transform = to_transform_msg(pose);
  broadcaster_.sendTransform(msg);
}

}  // namespace clothsim_ros
