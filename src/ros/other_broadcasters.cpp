#include "clothsim/ros/other_broadcasters.h"

#include <ros/master.h>
#include <ros/this_node.h>
#include <tf2/exceptions.h>

#include <algorithm>

#include "clothsim/ros/conversions.h"
#include "clothsim/ros/stamps.h"

namespace clothsim_ros {
namespace {

/// A node that is silent for longer no longer broadcasts its frame.
const ros::WallDuration silence(1);

/// Smallest step of a stamp after rounding to double precision, fifty years on [s].
const ros::Duration stamp_step(1e-6);

constexpr std::uint32_t watched_clock_queue = 1;

/// The master's value, as this node has the parameter remapped to use wall time itself.
bool others_use_sim_time() {
  XmlRpc::XmlRpcValue request;
  XmlRpc::XmlRpcValue response;
  XmlRpc::XmlRpcValue value;
  request[0] = ros::this_node::getName();
  request[1] = "/use_sim_time";
  return ros::master::execute("getParam", request, response, value, false) &&
         value.getType() == XmlRpc::XmlRpcValue::TypeBoolean && static_cast<bool>(value);
}

}  // namespace

OtherBroadcasters::OtherBroadcasters(ros::NodeHandle& node) : sim_time_(others_use_sim_time()) {
  subscribers_.listen(node, [this](const auto& event, bool is_static) { hear(event, is_static); });
  if (!sim_time_) return;
  clock_subscriber_ = node.subscribe<rosgraph_msgs::Clock>(
      "/clock", watched_clock_queue, [this](const auto& msg) { tick(msg->clock); });
}

void OtherBroadcasters::tick(const ros::Time& clock) {
  // Time ran backwards: subscribers discard all transforms, and later stamps would be in the
  // future.
  if (clock < clock_) newest_.clear();
  clock_ = clock;
}

void OtherBroadcasters::hear(const TfSubscribers::Event& event, bool is_static) {
  const std::string& node = event.getPublisherName();
  if (node == ros::this_node::getName()) return;
  for (const geometry_msgs::TransformStamped& transform : event.getMessage()->transforms) {
    if (!buffer_.setTransform(transform, node, true)) continue;  // logged by tf2
    const std::string& frame = transform.child_frame_id;
    heard_[frame] = {node, ros::SteadyTime::now(), is_static};
    newest_[frame] = std::max(newest_[frame], transform.header.stamp);
  }
}

std::string OtherBroadcasters::of(const std::string& frame) const {
  const auto known = heard_.find(frame);
  if (known == heard_.end()) return "";
  const Heard& heard = known->second;
  const bool holds = heard.is_static || ros::SteadyTime::now() - heard.when < silence;
  return holds ? heard.node : "";
}

std::optional<clothsim::Pose> OtherBroadcasters::pose(const std::string& world,
                                                      const std::string& frame) const {
  try {
    return to_pose(buffer_.lookupTransform(world, frame, ros::Time(0)).transform);
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }
}

ros::Time OtherBroadcasters::next_stamp(const std::string& frame) {
  ros::Time& newest = newest_[frame];
  const ros::Time now = sim_time_ ? clock_ : ros::Time::now();
  // Our own subscribers have refused a stamp in the future, and would refuse one after it, too.
  newest = is_ahead(newest, now) ? now : std::max(newest + stamp_step, now);
  return newest;
}

}  // namespace clothsim_ros
