#include "clothsim/ros/contact_topics.h"

#include <clothsim/Contacts.h>
#include <geometry_msgs/WrenchStamped.h>

#include <algorithm>
#include <utility>

#include "clothsim/ros/conversions.h"
#include "clothsim/ros/names.h"
#include "clothsim/run/touches.h"

namespace clothsim_ros {
namespace {

/// Messages queued for a slow subscriber: about a second's.
constexpr std::uint32_t contacts_queue = 100;

clothsim::Contacts to_contacts_msg(const clothsim::Simulator& simulator) {
  clothsim::Contacts msg;
  const std::vector<clothsim::ColliderSpec>& colliders = simulator.scene().colliders;
  const std::vector<clothsim::Touch> touches = clothsim::find_touches(simulator);
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    clothsim::ContactWrench of_one;
    of_one.name = colliders[i].name;
    of_one.frame = colliders[i].frame;
    of_one.wrench = to_wrench_msg(simulator.collider_wrenches()[i]);
    of_one.origin = to_point_msg(simulator.collider_pose(static_cast<int>(i)).position);
    of_one.count = static_cast<std::uint32_t>(touches[i].count);
    of_one.middle = to_point_msg(touches[i].middle);
    msg.colliders.push_back(std::move(of_one));
  }
  return msg;
}

/// The wrench on a collider at `pose`: in the tf frame that carries it, about that frame's origin;
/// without one in the world, about the world's origin. `wrench`: about the collider's own origin.
geometry_msgs::WrenchStamped to_stamped_wrench_msg(const clothsim::Wrench& wrench,
                                                   const clothsim::ColliderSpec& collider,
                                                   const clothsim::Pose& pose,
                                                   const std::string& world_frame) {
  const bool has_frame = !collider.frame.empty();
  const clothsim::Pose frame =
      has_frame ? clothsim::frame_of(pose, collider.offset) : clothsim::Pose();
  clothsim::Wrench about_frame{{0, 0, 0}, wrench.torque};
  about_frame.add(pose.position - frame.position, wrench.force);
  geometry_msgs::WrenchStamped msg;
  msg.header.frame_id = has_frame ? collider.frame : world_frame;
  msg.wrench = to_wrench_msg(about_frame, frame.orientation);
  return msg;
}

}  // namespace

ContactTopics::ContactTopics(const ros::NodeHandle& node, clothsim::Simulator& simulator,
                             std::string world_frame)
    : node_(node),
      simulator_(simulator),
      world_frame_(std::move(world_frame)),
      contacts_(node_.advertise<clothsim::Contacts>("contacts", contacts_queue)) {
  follow_scene();
}

void ContactTopics::follow_scene() {
  const std::vector<clothsim::ColliderSpec>& colliders = simulator_.scene().colliders;
  wrenches_.clear();
  const std::vector<std::string> in_ros = ros_names(colliders);
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    const std::string topic = "contact_wrench/" + in_ros[i];
    wrenches_.push_back({i, node_.advertise<geometry_msgs::WrenchStamped>(topic, contacts_queue)});
  }
}

void ContactTopics::ask(bool others_ask) {
  asked_ = contacts_.getNumSubscribers() > 0 ||
           std::any_of(wrenches_.begin(), wrenches_.end(), [](const WrenchTopic& topic) {
             return topic.publisher.getNumSubscribers() > 0;
           });
  simulator_.measure_wrenches(asked_ || others_ask);
}

void ContactTopics::publish(const ros::Time& stamp, std::uint64_t step) {
  if (!asked_) return;
  if (contacts_.getNumSubscribers() > 0) {
    clothsim::Contacts msg = to_contacts_msg(simulator_);
    msg.header.stamp = stamp;
    msg.header.frame_id = world_frame_;
    msg.step = step;
    contacts_.publish(msg);
  }
  for (const WrenchTopic& topic : wrenches_) {
    if (topic.publisher.getNumSubscribers() == 0) continue;
    geometry_msgs::WrenchStamped msg = to_stamped_wrench_msg(
        simulator_.collider_wrenches()[topic.collider],
        simulator_.scene().colliders[topic.collider],
        simulator_.collider_pose(static_cast<int>(topic.collider)), world_frame_);
    msg.header.stamp = stamp;
    topic.publisher.publish(msg);
  }
}

}  // namespace clothsim_ros
