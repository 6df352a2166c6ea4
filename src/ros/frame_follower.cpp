#include "clothsim/ros/frame_follower.h"

#include <ros/console.h>
#include <tf2/exceptions.h>

#include <utility>

#include "clothsim/ros/conversions.h"

namespace clothsim_ros {
namespace {

/// A frame whose latest transform is older is lost [s]. Slower publishers than 1 Hz are no motion.
constexpr double lost_after = 1;

/// Positions farther out are no place for a cloth [m]; the scene has the same limit.
constexpr double farthest = 1e6;

bool is_usable(const clothsim::Pose& pose) {
  return pose.orientation.coeffs().allFinite() &&
         (pose.position.array().abs() <= farthest).all();  // false for NaN
}

bool same(const clothsim::Pose& a, const clothsim::Pose& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs();
}

}  // namespace

FrameFollower::FrameFollower(const clothsim::Scene& scene, std::string world_frame)
    : world_frame_(std::move(world_frame)) {
  const auto add = [&](const std::string& frame, bool is_pin, size_t index) {
    if (frame.empty()) return;
    Follower follower;
    follower.status.frame = frame;
    follower.is_pin = is_pin;
    follower.index = static_cast<int>(index);
    followers_.push_back(follower);
  };
  for (size_t i = 0; i < scene.colliders.size(); ++i) add(scene.colliders[i].frame, false, i);
  for (size_t i = 0; i < scene.cloth.pinned.size(); ++i) add(scene.cloth.pinned[i].frame, true, i);
  if (!followers_.empty()) listener_.emplace(buffer_);
}

void FrameFollower::look_up() {
  for (Follower& follower : followers_) {
    const bool was_lost = follower.status.lost;
    look_up(follower);
    if (follower.status.lost && !was_lost) {
      ROS_WARN("Lost tf frame %s: what it carries stays where it was",
               follower.status.frame.c_str());
    }
  }
}

void FrameFollower::look_up(Follower& follower) {
  FrameStatus& status = follower.status;
  bool known = true;
  try {
    const geometry_msgs::TransformStamped transform =
        buffer_.lookupTransform(world_frame_, status.frame, ros::Time(0));
    const clothsim::Pose pose = to_pose(transform.transform);
    if (is_usable(pose)) {
      follower.latest = pose;
      follower.stamp = transform.header.stamp;
      status.seen = true;
    } else {
      ROS_WARN_THROTTLE(5, "Ignored a transform of tf frame %s: not finite or beyond %g m",
                        status.frame.c_str(), farthest);
    }
  } catch (const tf2::TransformException&) {
    known = false;
  }

  if (!status.seen) return;  // nothing to lose yet
  const bool is_static = follower.stamp.isZero();
  status.age = is_static ? 0 : (ros::Time::now() - follower.stamp).toSec();
  status.lost = !known || status.age > lost_after;
}

void FrameFollower::move(clothsim::Simulator& simulator) {
  for (Follower& follower : followers_) {
    if (!follower.latest) continue;
    const clothsim::Pose& pose = *follower.latest;
    const bool is_first = !follower.applied;
    if (!is_first && same(pose, *follower.applied)) continue;

    if (follower.is_pin) {
      if (is_first) {
        const auto& pin = simulator.scene().cloth.pinned[static_cast<size_t>(follower.index)];
        const int point = pin.row * simulator.cloth().columns + pin.column;
        const clothsim::Vector3 position = simulator.state().positions.row(point);
        follower.pin_offset = pose.orientation.conjugate() * (position - pose.position);
      } else {
        simulator.move_pin(follower.index, pose.position + pose.orientation * follower.pin_offset);
      }
    } else if (is_first) {
      simulator.place_collider(follower.index, pose);
    } else {
      simulator.move_collider(follower.index, pose);
    }
    follower.applied = pose;
  }
}

void FrameFollower::reset() {
  for (Follower& follower : followers_) follower.applied.reset();
}

std::vector<FrameStatus> FrameFollower::status() const {
  std::vector<FrameStatus> all;
  for (const Follower& follower : followers_) all.push_back(follower.status);
  return all;
}

}  // namespace clothsim_ros
