#include "grab_tool.h"

#include <OgreCamera.h>
#include <OgreRay.h>
#include <OgreViewport.h>
#include <clothsim/Attach.h>
#include <clothsim/Detach.h>
#include <ros/this_node.h>
#include <rviz/display_context.h>
#include <rviz/display_group.h>
#include <rviz/properties/float_property.h>
#include <rviz/render_panel.h>
#include <rviz/view_controller.h>
#include <rviz/viewport_mouse_event.h>

#include <algorithm>
#include <pluginlib/class_list_macros.hpp>
#include <vector>

#include "cloth_mesh.h"
#include "clothsim/ros/conversions.h"
#include "clothsim/ros/names.h"

namespace clothsim_rviz {
namespace {

using clothsim::Vector3;

constexpr double notch = 120;        // Qt's wheel_delta of one notch
constexpr double push_share = 0.05;  // of the distance to the camera, per notch

Vector3 to_eigen(const Ogre::Vector3& v) { return {v.x, v.y, v.z}; }

/// The cloths shown by the displays in the group and below it.
void add_shown(rviz::DisplayGroup& group, std::vector<ClothDisplay::Shown>& all) {
  for (int i = 0; i < group.numDisplays(); ++i) {
    rviz::Display* display = group.getDisplayAt(i);
    if (auto* inner = dynamic_cast<rviz::DisplayGroup*>(display)) add_shown(*inner, all);
    const auto* cloth = dynamic_cast<const ClothDisplay*>(display);
    if (cloth == nullptr) continue;
    if (auto shown = cloth->shown()) all.push_back(*shown);
  }
}

/// The free points within `radius` of a place, and the nearest point if it is free.
std::vector<std::int32_t> free_points(const ClothDisplay::Shown& cloth, const Hit& hit,
                                      double radius) {
  const std::vector<float>& xyz = cloth.state->positions;
  const auto is_among = [](const std::vector<std::uint32_t>& points, std::uint32_t point) {
    return std::binary_search(points.begin(), points.end(), point);
  };
  std::vector<std::int32_t> points;
  for (std::uint32_t i = 0; 3 * std::size_t{i} < xyz.size(); ++i) {
    const float* p = &xyz[3 * std::size_t{i}];
    const bool near = (Vector3(p[0], p[1], p[2]) - hit.place).norm() <= radius;
    if (!near && i != hit.point) continue;
    if (is_among(cloth.topology->pinned, i) || is_among(cloth.state->held, i)) continue;
    points.push_back(static_cast<std::int32_t>(i));
  }
  return points;
}

}  // namespace

GrabTool::GrabTool() {
  shortcut_key_ = 'g';
  radius_ =
      new rviz::FloatProperty("Radius", 0.03f, "Points within this distance are taken hold of [m].",
                              getPropertyContainer());
  radius_->setMin(0);
  tear_force_ = new rviz::FloatProperty("Tear Force", 0,
                                        "Pull beyond which the cloth slips away [N]; 0: never.",
                                        getPropertyContainer());
  tear_force_->setMin(0);
}

GrabTool::~GrabTool() { release(); }

void GrabTool::onInitialize() {
  setName("Grab");
  broadcaster_ = std::make_unique<tf2_ros::TransformBroadcaster>();
  frame_ = clothsim_ros::to_ros_name(ros::this_node::getName().substr(1), "node_") + "_grab";
}

int GrabTool::processMouseEvent(rviz::ViewportMouseEvent& event) {
  if (event.leftDown()) {
    grab(event);
  } else if (event.leftUp()) {
    release();
  } else if (hold_ && event.wheel_delta != 0) {
    push(event);
  } else if (hold_ && event.left()) {
    drag(event);
  } else if (event.panel->getViewController() != nullptr) {
    event.panel->getViewController()->handleMouseEvent(event);
  }
  return Render;
}

GrabTool::Ray GrabTool::ray_of(const rviz::ViewportMouseEvent& event,
                               const clothsim::Pose& in_fixed) {
  const Ogre::Camera& camera = *event.viewport->getCamera();
  const auto share = [](int pixel, int size) {
    return static_cast<float>(pixel) / static_cast<float>(size);
  };
  const Ogre::Ray ray =
      camera.getCameraToViewportRay(share(event.x, event.viewport->getActualWidth()),
                                    share(event.y, event.viewport->getActualHeight()));
  const Eigen::Quaterniond back = in_fixed.orientation.conjugate();
  return {back * (to_eigen(ray.getOrigin()) - in_fixed.position),
          (back * to_eigen(ray.getDirection())).normalized(),
          (back * to_eigen(camera.getDerivedDirection())).normalized()};
}

void GrabTool::grab(const rviz::ViewportMouseEvent& event) {
  release();  // of a button that was released elsewhere
  std::vector<ClothDisplay::Shown> all;
  add_shown(*context_->getRootDisplayGroup(), all);
  std::optional<Hit> first;
  const ClothDisplay::Shown* cloth = nullptr;
  for (const ClothDisplay::Shown& shown : all) {
    const Ray ray = ray_of(event, shown.in_fixed);
    const auto hit =
        first_hit(ray.origin, ray.direction, shown.state->positions, shown.topology->triangles);
    if (!hit || (first && first->distance <= hit->distance)) continue;
    first = hit;
    cloth = &shown;
  }
  if (!first) {
    setStatus(all.empty() ? "No clothsim/Cloth display shows a cloth" : "No cloth there");
    return;
  }
  const std::vector<std::int32_t> points = free_points(*cloth, *first, radius_->getFloat());
  if (points.empty()) {
    setStatus("The points there are held already");
    return;
  }
  hold_ = Hold{cloth->node, cloth->world_frame, cloth->in_fixed, first->place,
               std::make_shared<bool>(false)};
  broadcast();
  attach(*hold_, points);
}

void GrabTool::attach(const Hold& hold, const std::vector<std::int32_t>& points) {
  clothsim::Attach service;
  service.request.frame = frame_;
  service.request.points = points;
  service.request.tear_force = tear_force_->getFloat();
  setStatus(QString("Holding %1 points").arg(points.size()));
  calls_.post(
      [this, service, node = hold.node, attached = hold.attached]() mutable -> CallQueue::Answer {
        // An RViz of the same name that a signal ended may have left its points attached. Mostly
        // refused.
        clothsim::Detach left;
        left.request.frame = service.request.frame;
        refusal_of(node + "/detach", left);
        const std::string refusal = refusal_of(node + "/attach", service);
        *attached = refusal.empty();
        if (refusal.empty()) return {};
        return [this, refusal, attached] {
          if (hold_ && hold_->attached == attached) hold_.reset();
          setStatus(QString::fromStdString(refusal));
        };
      });
}

void GrabTool::drag(const rviz::ViewportMouseEvent& event) {
  // In the plane of the picture.
  const Ray ray = ray_of(event, hold_->in_fixed);
  const double slope = ray.direction.dot(ray.ahead);
  const double distance = (hold_->place - ray.origin).dot(ray.ahead) / slope;
  if (!(slope > 0 && distance > 0)) return;
  hold_->place = ray.origin + distance * ray.direction;
  broadcast();
}

void GrabTool::push(const rviz::ViewportMouseEvent& event) {
  const Ray ray = ray_of(event, hold_->in_fixed);
  hold_->place += push_share * event.wheel_delta / notch * (hold_->place - ray.origin);
  broadcast();
}

void GrabTool::release() {
  if (!hold_) return;
  calls_.post([this, frame = frame_, name = hold_->node + "/detach",
               attached = hold_->attached]() -> CallQueue::Answer {
    if (!*attached) return {};
    clothsim::Detach service;
    service.request.frame = frame;
    const std::string refusal = refusal_of(name, service);
    return [this, refusal] { setStatus(QString::fromStdString(refusal)); };
  });
  hold_.reset();
}

void GrabTool::update(float, float) {
  if (hold_) broadcast();
}

void GrabTool::broadcast() {
  // Subscribers drop transforms without a later stamp than the last, and time may stand still.
  stamp_ = std::max(ros::Time::now(), stamp_ + ros::Duration(0, 1));
  geometry_msgs::TransformStamped msg;
  msg.header.stamp = stamp_;
  msg.header.frame_id = hold_->world_frame;
  msg.child_frame_id = frame_;
  msg.transform = clothsim_ros::to_transform_msg({hold_->place, Eigen::Quaterniond::Identity()});
  broadcaster_->sendTransform(msg);
}

}  // namespace clothsim_rviz

PLUGINLIB_EXPORT_CLASS(clothsim_rviz::GrabTool, rviz::Tool)
