#include "clothsim/ros/body_topics.h"

#include <ros/single_subscriber_publisher.h>

#include <utility>

#include "clothsim/model/checks.h"
#include "clothsim/ros/conversions.h"
#include "clothsim/ros/names.h"

namespace clothsim_ros {
namespace {

/// Messages queued for a slow subscriber: about a second's.
constexpr std::uint32_t bodies_queue = 100;

}  // namespace

BodyTopics::BodyTopics(const ros::NodeHandle& node, clothsim::Simulator& simulator,
                       Grasper& grasper, Changes& changes, std::string world_frame,
                       std::function<void()> redraw)
    : node_(node),
      simulator_(simulator),
      grasper_(grasper),
      changes_(changes),
      world_frame_(std::move(world_frame)),
      redraw_(std::move(redraw)) {
  follow_scene();
}

void BodyTopics::follow_scene() {
  all_.clear();
  const std::vector<std::string> in_ros = ros_names(simulator_.scene().colliders);
  for (std::size_t i = 0; i < in_ros.size(); ++i) {
    const auto collider = static_cast<int>(i);
    if (simulator_.is_body(collider)) all_.push_back({collider, in_ros[i]});
  }
  if (all_.empty()) {
    bodies_.shutdown();
    tf_.shutdown();
    services_.clear();
    bodies_ = tf_ = ros::Publisher();
    return;
  }
  if (bodies_) return;
  bodies_ = node_.advertise<clothsim::Bodies>(
      "bodies", bodies_queue,
      [this](const ros::SingleSubscriberPublisher& listener) { listener.publish(message()); });
  tf_ = node_.advertise<tf2_msgs::TFMessage>(
      "/tf", bodies_queue,
      [this](const ros::SingleSubscriberPublisher& listener) { listener.publish(transforms()); });
  services_ = {node_.advertiseService("set_body", &BodyTopics::set_body, this),
               node_.advertiseService("attach_body", &BodyTopics::attach_body, this),
               node_.advertiseService("detach_body", &BodyTopics::detach_body, this)};
}

clothsim::Bodies BodyTopics::message() const {
  clothsim::Bodies msg;
  msg.header.frame_id = world_frame_;
  msg.header.stamp = stamp_;
  msg.step = step_;
  for (const Body& body : all_) {
    const auto i = static_cast<std::size_t>(body.collider);
    const clothsim::ColliderSpec& spec = simulator_.scene().colliders[i];
    const clothsim::BodyMotion motion = simulator_.body_motion(body.collider);
    clothsim::BodyState state;
    state.name = spec.name;
    state.frame = simulator_.frame_of_body(body.collider).value_or("");
    state.mass = spec.body->mass;
    state.pose = to_pose_msg(motion.pose);
    state.twist.linear = to_vector_msg(motion.velocity);
    state.twist.angular = to_vector_msg(motion.angular_velocity);
    state.wrench = to_wrench_msg(simulator_.body_wrench(body.collider));
    msg.bodies.push_back(std::move(state));
  }
  return msg;
}

tf2_msgs::TFMessage BodyTopics::transforms() const {
  tf2_msgs::TFMessage msg;
  for (const Body& body : all_) {
    geometry_msgs::TransformStamped transform;
    transform.header.frame_id = world_frame_;
    transform.header.stamp = stamp_;
    transform.child_frame_id = body.frame;
    transform.transform = to_transform_msg(simulator_.collider_pose(body.collider));
    msg.transforms.push_back(std::move(transform));
  }
  return msg;
}

void BodyTopics::publish(const ros::Time& stamp, std::uint64_t step) {
  stamp_ = stamp;
  step_ = step;
  if (all_.empty()) return;
  if (tf_.getNumSubscribers() > 0) tf_.publish(transforms());
  if (bodies_.getNumSubscribers() > 0) bodies_.publish(message());
}

int BodyTopics::find(const std::string& name) const {
  std::vector<std::string> names;
  for (const Body& body : all_) {
    names.push_back(simulator_.scene().colliders[static_cast<std::size_t>(body.collider)].name);
    if (names.back() == name) return body.collider;
  }
  throw clothsim::InvalidValue({"name"}, '"' + name + '"', "one of " + clothsim::join(names));
}

bool BodyTopics::set_body(clothsim::SetBody::Request& request,
                          clothsim::SetBody::Response& response) {
  clothsim::Change change;
  change.collider = request.name;
  const clothsim::Pose pose = to_pose(request.pose);
  change.transform = to_transform_msg(pose);
  change.twist = request.twist;
  try {
    simulator_.set_body(find(request.name), pose, to_vector(request.twist.linear),
                        to_vector(request.twist.angular));
  } catch (const clothsim::InvalidValue& error) {
    response.message = error.what();
    return true;
  }
  changes_.publish("set_body", change);
  redraw_();
  response.success = true;
  return true;
}

bool BodyTopics::attach_body(clothsim::AttachBody::Request& request,
                             clothsim::AttachBody::Response& response) {
  try {
    grasper_.attach_body(find(request.name), request.frame);
  } catch (const clothsim::InvalidValue& error) {
    response.message = error.message("", "/");
    return true;
  }
  clothsim::Change change;
  change.collider = request.name;
  change.frame = request.frame;
  changes_.publish("attach_body", change);
  response.success = true;
  return true;
}

bool BodyTopics::detach_body(clothsim::DetachBody::Request& request,
                             clothsim::DetachBody::Response& response) {
  try {
    grasper_.detach_body(find(request.name));
  } catch (const clothsim::InvalidValue& error) {
    response.message = error.message("", "/");
    return true;
  }
  clothsim::Change change;
  change.collider = request.name;
  changes_.publish("detach_body", change);
  response.success = true;
  return true;
}

}  // namespace clothsim_ros
