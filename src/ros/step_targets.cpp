#include "clothsim/ros/step_targets.h"

#include <ros/console.h>
#include <ros/single_subscriber_publisher.h>
#include <tf2/exceptions.h>

#include <algorithm>
#include <optional>

#include "clothsim/model/checks.h"
#include "clothsim/model/nearest_word.h"
#include "clothsim/ros/conversions.h"

namespace clothsim_ros {
namespace {

using clothsim::InvalidValue;
using clothsim::Pose;

/// Frames of a call that wait for a slow subscriber.
constexpr std::uint32_t tf_queue = 100;

Pose combined(const Pose& parent, const Pose& child) {
  return {parent.position + parent.orientation * child.position,
          (parent.orientation * child.orientation).normalized()};
}

geometry_msgs::TransformStamped to_msg(const std::string& world, const std::string& frame,
                                       const Pose& pose) {
  geometry_msgs::TransformStamped msg;
  msg.header.frame_id = world;
  msg.child_frame_id = frame;
  msg.transform = to_transform_msg(pose);
  return msg;
}

}  // namespace

StepTargets::Target StepTargets::read(const clothsim::Step::Request& request,
                                      std::size_t index) const {
  const geometry_msgs::TransformStamped& msg = request.targets[index];
  const std::string& frame = msg.child_frame_id;
  clothsim::inside("child_frame_id", [&] {
    if (frame.empty()) throw InvalidValue({}, "nothing", "the name of a frame");
    clothsim::check_frame(frame);
    if (tf_.carries(frame, tf_.world_frame())) {
      throw InvalidValue({}, '"' + frame + '"', "a frame that " + tf_.world_frame() + " is not in");
    }
  });
  const std::string& parent = msg.header.frame_id;
  const std::optional<Pose> base =
      parent.empty() || parent == tf_.world_frame() ? Pose() : tf_.pose(parent);
  if (!base) {
    throw InvalidValue({"header", "frame_id"}, '"' + parent + '"',
                       "a tf frame with a transform to " + tf_.world_frame());
  }
  const Pose given = to_pose(msg.transform);
  if (!is_usable(given)) {
    throw InvalidValue({"transform"}, "one that is not finite, too far or has no rotation",
                       "numbers of at most " + clothsim::to_text(largest_coordinate) + " [m]");
  }
  const bool is_in_world = parent.empty() || parent == tf_.world_frame();
  Target target{frame, {is_in_world ? given : combined(*base, given)}};
  if (!request.twists.empty()) {
    const geometry_msgs::Twist& twist = request.twists[index];
    target.target.twist = clothsim::Twist{base->orientation * to_vector(twist.linear),
                                          base->orientation * to_vector(twist.angular)};
  }
  clothsim::check(target.target);
  return target;
}

clothsim::FrameMotion StepTargets::start(const Target& target,
                                         const clothsim::Simulator& simulator) const {
  const std::optional<Pose> now = tf_.pose(target.frame);
  const auto known = motions_.find(target.frame);
  // A frame that nobody else has moved since continues its motion.
  if (known != motions_.end() && now && same(*now, to_pose(to_transform_msg(known->second.pose()))))
    return known->second;
  if (now) return clothsim::FrameMotion(*now);
  return clothsim::FrameMotion(
      clothsim::followed_pose(target.frame, simulator).value_or(target.target.pose));
}

void StepTargets::set_targets(const clothsim::Step::Request& request,
                              const clothsim::Simulator& simulator,
                              const std::vector<std::string>& followed) {
  tf_.receive();
  tf_.hold();
  if (!request.twists.empty() && request.twists.size() != request.targets.size()) {
    throw InvalidValue(
        {"twists"}, std::to_string(request.twists.size()) + " items",
        "none, or one for each of " + std::to_string(request.targets.size()) + " targets");
  }
  std::map<std::string, clothsim::FrameMotion> motions;
  for (std::size_t i = 0; i < request.targets.size(); ++i) {
    clothsim::inside("targets", [&] {
      clothsim::inside(std::to_string(i), [&] {
        const Target target = read(request, i);
        const auto [motion, is_new] = motions.emplace(target.frame, start(target, simulator));
        if (!is_new) {
          throw InvalidValue({"child_frame_id"}, '"' + target.frame + "\" again", "it once");
        }
        motion->second.set_target(target.target, static_cast<int>(request.frames),
                                  simulator.frame_duration());
      });
    });
  }
  if (motions.empty()) return;
  if (!publisher_) {
    publisher_ = node_.advertise<tf2_msgs::TFMessage>(
        "/tf", tf_queue,
        [this](const ros::SingleSubscriberPublisher& listener) { listener.publish(message()); });
  }
  for (const auto& [frame, motion] : motions) {
    tell_stranger(frame, followed);
    motions_.insert_or_assign(frame, motion);
    begin_.emplace(frame, motion.pose());
    moving_.push_back(frame);
    put(frame, motion.pose());
  }
}

void StepTargets::tell_stranger(const std::string& frame,
                                const std::vector<std::string>& followed) {
  const bool is_followed = std::any_of(followed.begin(), followed.end(), [&](const auto& child) {
    return tf_.carries(frame, child);
  });
  if (is_followed || !strangers_.insert(frame).second) return;
  const std::string told =
      "~step moves frame " + frame + ", which no collider, pin, attached point or camera follows";
  const std::string meant = clothsim::nearest_word(frame, followed);
  if (meant.empty()) {
    ROS_INFO("%s yet", told.c_str());  // a gripper may come before it grasps
  } else {
    ROS_WARN("%s; did you mean %s?", told.c_str(), meant.c_str());
  }
}

void StepTargets::advance() {
  for (const std::string& frame : moving_) put(frame, motions_.at(frame).advance());
}

void StepTargets::broadcast(const ros::Time& stamp) {
  stamp_ = stamp;
  if (publisher_.getNumSubscribers() == 0) return;
  const tf2_msgs::TFMessage msg = message();
  if (!msg.transforms.empty()) publisher_.publish(msg);
}

/// The poses of the frames that nobody else has moved since.
tf2_msgs::TFMessage StepTargets::message() const {
  tf2_msgs::TFMessage msg;
  for (const auto& [frame, motion] : motions_) {
    if (!tf_.holds(frame)) continue;
    msg.transforms.push_back(to_msg(tf_.world_frame(), frame, motion.pose()));
    msg.transforms.back().header.stamp = stamp_;
  }
  return msg;
}

void StepTargets::put(const std::string& frame, const Pose& pose) {
  tf_.put(to_msg(tf_.world_frame(), frame, pose));
}

void StepTargets::reset(const clothsim::Scene& scene) {
  for (auto& [frame, motion] : motions_) {
    if (!tf_.holds(frame)) continue;
    const auto follows = [&name = frame](const auto& collider) { return collider.frame == name; };
    const auto collider = std::find_if(scene.colliders.begin(), scene.colliders.end(), follows);
    motion = clothsim::FrameMotion(collider == scene.colliders.end() ? begin_.at(frame)
                                                                     : collider->pose);
    put(frame, motion.pose());
  }
}

void StepTargets::restore(const Saved& saved) {
  for (auto& [frame, motion] : motions_) {
    if (saved.count(frame) > 0 || !tf_.holds(frame)) continue;
    motion = clothsim::FrameMotion(begin_.at(frame));  // it has not moved yet
    put(frame, motion.pose());
  }
  for (const auto& [frame, motion] : saved) {
    if (!tf_.holds(frame)) continue;
    motions_.insert_or_assign(frame, motion);
    put(frame, motion.pose());
  }
}

}  // namespace clothsim_ros
