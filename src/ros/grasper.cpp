#include "clothsim/ros/grasper.h"

#include <geometry_msgs/WrenchStamped.h>
#include <ros/console.h>
#include <ros/single_subscriber_publisher.h>
#include <ros/time.h>

#include <algorithm>
#include <utility>

#include "clothsim/model/checks.h"
#include "clothsim/ros/conversions.h"
#include "clothsim/ros/names.h"
#include "clothsim/scene/points_yaml.h"
#include "clothsim/scene/scene_yaml.h"

namespace clothsim_ros {
namespace {

using clothsim::InvalidValue;

/// Messages queued for a slow subscriber: about a second's.
constexpr std::uint32_t wrench_queue = 100;

/// How long the topic of a frame that has released its points stays: the last wrench must be sent,
/// and subscribers need not connect again if the frame soon grasps again.
const ros::WallDuration linger(1);

/// Longest text of places: more than a hundred thousand of them.
constexpr std::size_t longest_places = 10'000'000;

/// Below the node's name; characters that are invalid in a topic become underscores.
std::string wrench_topic(const std::string& frame) {
  return "wrench/" + to_ros_name(frame, "frame_");
}

geometry_msgs::WrenchStamped to_stamped_msg(const std::string& frame, const ros::Time& stamp) {
  geometry_msgs::WrenchStamped msg;
  msg.header.stamp = stamp;
  msg.header.frame_id = frame;
  return msg;
}

geometry_msgs::WrenchStamped to_stamped_msg(const std::string& frame, const clothsim::Grip& grip,
                                            const ros::Time& stamp) {
  geometry_msgs::WrenchStamped msg = to_stamped_msg(frame, stamp);
  msg.wrench = to_wrench_msg(grip.wrench, grip.pose.orientation);
  return msg;
}

/// The points that a request of ~attach or ~detach names by number or place. Throws InvalidValue.
template <typename Request>
std::vector<int> points_of(const Request& request, const clothsim::Simulator& simulator) {
  if (!request.places.empty() && !request.points.empty()) {
    throw InvalidValue({"places"}, "places and points", "one of the two");
  }
  if (request.places.empty() && !request.cloth.empty()) {
    throw InvalidValue({"cloth"}, '"' + request.cloth + '"', "none without places");
  }
  if (request.places.empty()) return {request.points.begin(), request.points.end()};
  if (request.places.size() > longest_places) {
    throw InvalidValue({"places"}, std::to_string(request.places.size()) + " characters",
                       "at most " + std::to_string(longest_places));
  }
  clothsim::PointReaders readers(simulator.scene().cloth, &simulator.cloth());
  clothsim::PointReader& reader = request.cloth.empty() ? readers.all() : readers.of(request.cloth);
  const YAML::Node list = clothsim::load_scene_text(request.places, "places");
  std::vector<int> points;
  clothsim::inside("places", [&] { points = clothsim::read_points(list, reader); });
  if (points.empty()) throw InvalidValue({"places"}, "none", "one or more");
  return points;
}

/// Largest distance of the points and bodies from the frame's origin [m].
double reach(const clothsim::Grip& grip) {
  double farthest = 0;
  for (const clothsim::Grip::Held& held : grip.held)
    farthest = std::max(farthest, held.offset.norm());
  for (const clothsim::Grip::HeldBody& body : grip.bodies)
    farthest = std::max(farthest, body.offset.position.norm());
  return farthest;
}

std::vector<int> sorted(std::vector<int> points) {
  std::sort(points.begin(), points.end());
  return points;
}

}  // namespace

Grasper::Grasper(const ros::NodeHandle& node, clothsim::Simulator& simulator, TfListener& tf,
                 Changes& changes, const Pacer& pacer, double jump_speed)
    : node_(node),
      simulator_(simulator),
      tf_(tf),
      changes_(changes),
      pacer_(pacer),
      speed_limit_(jump_speed) {
  services_ = {node_.advertiseService("attach", &Grasper::attach, this),
               node_.advertiseService("detach", &Grasper::detach, this)};
}

void Grasper::look_up() {
  for (auto& [name, frame] : frames_) frame.look_up();
  end_old_topics();
}

void Grasper::move() {
  for (const auto& [name, frame] : frames_) {
    changes_.follow(frame);
    if (!frame.pose()) continue;
    const clothsim::Grip& grip = simulator_.grips().at(name);
    simulator_.move_grip(name, speed_limit_.toward(grip.pose, *frame.pose(), reach(grip),
                                                   simulator_.frame_duration(), name));
  }
}

void Grasper::update(const ros::Time& stamp) {
  for (const auto& [name, frame] : frames_) {
    if (simulator_.grips().count(name) == 0) ROS_WARN("The cloth tore off frame %s", name.c_str());
  }
  follow_grips();
  for (auto& [name, topic] : topics_) {
    if (topic.let_go) continue;
    topic.stamp = stamp;
    if (topic.publisher.getNumSubscribers() == 0) continue;
    const clothsim::Grip& grip = simulator_.grips().at(topic.frame);
    topic.publisher.publish(to_stamped_msg(topic.frame, grip, stamp));
  }
}

void Grasper::follow_grips() {
  const auto& grips = simulator_.grips();
  for (auto frame = frames_.begin(); frame != frames_.end();) {
    const auto grip = grips.find(frame->first);
    const bool is_held = grip != grips.end() && !grip->second.on_body;
    frame = is_held ? std::next(frame) : frames_.erase(frame);
  }
  for (auto& [name, topic] : topics_) {
    if (!topic.let_go && grips.count(topic.frame) == 0) let_go(topic);
  }
  for (const auto& [name, grip] : grips) {
    if (!grip.on_body) frames_.try_emplace(name, name, tf_);
    take_hold(name);
  }
}

void Grasper::take_hold(const std::string& frame) {
  const std::string name = wrench_topic(frame);
  WrenchTopic& topic = topics_[name];
  if (!topic.publisher) {
    topic.publisher = node_.advertise<geometry_msgs::WrenchStamped>(
        name, wrench_queue, [this, name](const ros::SingleSubscriberPublisher& subscriber) {
          greet(topics_.at(name), subscriber);
        });
  } else if (!topic.let_go) {
    return;
  }
  topic.frame = frame;
  topic.stamp.reset();
  topic.let_go.reset();
}

void Grasper::let_go(WrenchTopic& topic) {
  topic.let_go = ros::SteadyTime::now();
  if (topic.publisher.getNumSubscribers() == 0) return;
  topic.publisher.publish(to_stamped_msg(topic.frame, pacer_.now()));
}

void Grasper::greet(const WrenchTopic& topic,
                    const ros::SingleSubscriberPublisher& subscriber) const {
  const auto grip = simulator_.grips().find(topic.frame);
  if (!topic.stamp || grip == simulator_.grips().end()) return;
  subscriber.publish(to_stamped_msg(topic.frame, grip->second, *topic.stamp));
}

void Grasper::end_old_topics() {
  const ros::SteadyTime now = ros::SteadyTime::now();
  for (auto topic = topics_.begin(); topic != topics_.end();) {
    const std::optional<ros::SteadyTime>& let_go = topic->second.let_go;
    topic = let_go && now - *let_go > linger ? topics_.erase(topic) : std::next(topic);
  }
}

void Grasper::check_topic(const std::string& frame) const {
  for (const auto& [name, grip] : simulator_.grips()) {
    if (name != frame && wrench_topic(name) == wrench_topic(frame)) {
      throw InvalidValue({"frame"}, '"' + frame + '"',
                         "a frame with a topic of its own: ~" + wrench_topic(frame) +
                             " is that of \"" + name + '"');
    }
  }
}

clothsim::Pose Grasper::first_pose(TfFrame& frame) const {
  frame.wait_for_first();
  if (frame.pose()) return *frame.pose();
  throw InvalidValue({"frame"}, '"' + frame.status().frame + '"',
                     "a tf frame with a transform to " + tf_.world_frame());
}

std::string Grasper::body_or_frame(const std::string& frame) const {
  const std::vector<clothsim::ColliderSpec>& colliders = simulator_.scene().colliders;
  const std::vector<std::string> in_tf = ros_names(colliders);
  for (std::size_t i = 0; i < in_tf.size(); ++i) {
    if (in_tf[i] == frame && simulator_.is_body(static_cast<int>(i))) return colliders[i].name;
  }
  return frame;
}

void Grasper::attach_body(int body, const std::string& frame_name) {
  clothsim::check_frame(frame_name);
  if (frame_name.empty()) throw InvalidValue({"frame"}, "nothing", "a tf frame");
  const std::string name = body_or_frame(frame_name);
  check_topic(name);
  TfFrame frame(name, tf_);
  const clothsim::Pose pose =
      simulator_.body_named(name) ? simulator_.collider_pose(body) : first_pose(frame);
  simulator_.attach_body(body, name, pose);
  follow_grips();
  look_up();
  changes_.follow(frame);
}

void Grasper::detach_body(int body) {
  simulator_.detach_body(body);
  follow_grips();
}

bool Grasper::attach(clothsim::Attach::Request& request, clothsim::Attach::Response& response) {
  try {
    // Check the request.
    clothsim::check_frame(request.frame);
    const std::string name = body_or_frame(request.frame);
    check_topic(name);
    std::vector<int> points = points_of(request, simulator_);
    const std::string radius = clothsim::to_text(request.radius);
    if (points.empty() && !(request.radius > 0)) {  // true for NaN
      throw InvalidValue({"radius"}, radius + " and no points", "a number above 0 [m], or points");
    }
    if (!points.empty() && request.radius != 0) {
      throw InvalidValue({"radius"}, radius + " and points", "one of the two");
    }

    // Find the frame's pose, and the points by it.
    TfFrame frame(name, tf_);
    const std::optional<int> body = simulator_.body_named(name);
    const clothsim::Pose pose = body ? simulator_.collider_pose(*body) : first_pose(frame);
    if (points.empty()) points = simulator_.free_points_near(pose.position, request.radius);

    std::optional<double> tear_force;
    if (request.tear_force != 0) tear_force = request.tear_force;
    std::optional<double> strength;
    if (request.strength != 0) strength = request.strength;
    simulator_.attach(name, pose, points, {tear_force, strength});
    follow_grips();
    look_up();
    if (!body) changes_.follow(frame);
    clothsim::Change change;
    change.frame = request.frame;
    change.points.assign(points.begin(), points.end());
    change.tear_force = request.tear_force;
    change.strength = request.strength;
    changes_.publish("attach", change);
    points = sorted(points);
    response.points.assign(points.begin(), points.end());
    response.success = true;
  } catch (const InvalidValue& error) {
    response.message = error.message("", "/");
  }
  return true;
}

bool Grasper::detach(clothsim::Detach::Request& request, clothsim::Detach::Response& response) {
  try {
    std::vector<int> held;
    const std::string named = body_or_frame(request.frame);
    for (const auto& [name, grip] : simulator_.grips()) {
      if (request.frame.empty() ? grip.on_body.has_value() : name != named) continue;
      for (const clothsim::Grip::Held& h : grip.held) held.push_back(h.point);
    }
    if (held.empty()) {
      throw InvalidValue({"frame"}, '"' + request.frame + '"',
                         request.frame.empty() ? "that something is attached"
                                               : "a frame that points are attached to");
    }
    held = sorted(std::move(held));
    std::vector<int> points = points_of(request, simulator_);
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (std::binary_search(held.begin(), held.end(), points[i])) continue;
      throw InvalidValue(
          {"points", std::to_string(i)}, std::to_string(points[i]),
          "a point that is attached" + (request.frame.empty() ? "" : " to " + request.frame));
    }
    if (points.empty()) points = held;

    simulator_.detach(points);
    follow_grips();
    points = sorted(points);
    points.erase(std::unique(points.begin(), points.end()), points.end());
    response.points.assign(points.begin(), points.end());
    clothsim::Change change;
    change.frame = request.frame;
    change.points = response.points;
    changes_.publish("detach", change);
    response.success = true;
  } catch (const InvalidValue& error) {
    response.message = error.message("", "/");
  }
  return true;
}

std::vector<FrameStatus> Grasper::status() const {
  std::vector<FrameStatus> all;
  for (const auto& [name, frame] : frames_) all.push_back(frame.status());
  return all;
}

}  // namespace clothsim_ros
