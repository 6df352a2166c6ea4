#include "clothsim/ros/frame_follower.h"

#include <algorithm>

#include "clothsim/shapes/shape.h"

namespace clothsim_ros {
namespace {

/// Bound on the displacement, by a change of pose, of the shape's points that are no farther out
/// than the cloth [m].
double distance_between(const clothsim::Pose& a, const clothsim::Pose& b,
                        const clothsim::ColliderSpec& collider, const clothsim::Points& cloth) {
  const double straight = (b.position - a.position).norm();
  const double angle = a.orientation.angularDistance(b.orientation);
  if (angle == 0) return straight;
  const double radius = clothsim::bounding_radius(collider.shape) + collider.offset.position.norm();
  const double reach = (cloth.rowwise() - a.position.transpose()).rowwise().norm().maxCoeff();
  return straight + angle * std::min(reach, radius);
}

}  // namespace

FrameFollower::FrameFollower(const clothsim::Scene& scene, TfListener& tf, double jump_speed)
    : fresh_watch_(jump_speed), speed_limit_(jump_speed) {
  const auto add = [&](const std::string& frame, bool is_pin, size_t index) {
    if (frame.empty()) return;
    followers_.push_back(
        {TfFrame(frame, tf), is_pin, static_cast<int>(index), {}, false, {{}, fresh_watch_}});
  };
  for (size_t i = 0; i < scene.colliders.size(); ++i) add(scene.colliders[i].frame, false, i);
  for (size_t i = 0; i < scene.cloth.pinned.size(); ++i) add(scene.cloth.pinned[i].frame, true, i);
}

void FrameFollower::look_up() {
  for (Follower& follower : followers_) follower.frame.look_up();
}

void FrameFollower::take_up(clothsim::Simulator& simulator, Changes& changes) {
  for (Follower& follower : followers_) {
    if (!follower.frame.pose() || follower.applied) continue;
    changes.follow(follower.frame);
    move(follower, simulator);
    follower.has_begun = true;
  }
}

void FrameFollower::move(clothsim::Simulator& simulator) {
  for (Follower& follower : followers_) {
    if (follower.frame.pose()) move(follower, simulator);
  }
}

void FrameFollower::move(Follower& follower, clothsim::Simulator& simulator) {
  if (follower.is_pin) {
    move_pin(follower, simulator);
  } else {
    move_collider(follower, simulator);
  }
  follower.applied = follower.frame.pose();
  follower.has_begun = false;
}

void FrameFollower::move_pin(Follower& follower, clothsim::Simulator& simulator) {
  const clothsim::Pose& pose = *follower.frame.pose();
  if (follower.applied && same(pose, *follower.applied) && !follower.late) return;
  const auto& pin = simulator.scene().cloth.pinned[static_cast<size_t>(follower.index)];
  const int point = pin.row * simulator.cloth().columns + pin.column;
  const clothsim::Vector3 position = simulator.state().positions.row(point);
  std::optional<clothsim::Vector3>& offset = follower.memory.pin_offset;
  if (!offset) {
    offset = pose.orientation.conjugate() * (position - pose.position);
  } else {
    const clothsim::Vector3 goal = pose.position + pose.orientation * *offset;
    const clothsim::Vector3 next = speed_limit_.toward(position, goal, simulator.frame_duration(),
                                                       follower.frame.status().frame);
    follower.late = next != goal;
    simulator.move_pin(follower.index, next);
  }
}

void FrameFollower::move_collider(Follower& follower, clothsim::Simulator& simulator) {
  const clothsim::Pose& pose = *follower.frame.pose();
  if (!follower.applied) {
    const auto index = static_cast<size_t>(follower.index);
    const clothsim::Pose wanted = pose * simulator.scene().colliders[index].offset;
    if (!same(wanted, simulator.collider_pose(follower.index)))
      simulator.place_collider(follower.index, pose);
    return;
  }
  double distance = 0;
  const bool moves = !same(pose, *follower.applied);
  if (moves) {
    const auto& collider = simulator.scene().colliders[static_cast<size_t>(follower.index)];
    distance = distance_between(*follower.applied, pose, collider, simulator.state().positions);
  }
  if (follower.memory.watch.jumps(distance, simulator.frame_duration())) {
    simulator.place_collider(follower.index, pose);
  } else if (moves) {
    simulator.move_collider(follower.index, pose);
  }
}

void FrameFollower::tell(Changes& changes) const {
  for (const Follower& follower : followers_)
    changes.follow(follower.frame, follower.has_begun ? "target" : "tf");
}

void FrameFollower::reset() {
  forget_applied();
  for (Follower& follower : followers_) follower.memory = {{}, fresh_watch_};
}

std::map<std::string, clothsim::Pose> FrameFollower::frames(
    const clothsim::Simulator& simulator) const {
  std::map<std::string, clothsim::Pose> all;
  for (const Follower& follower : followers_) {
    const std::string& name = follower.frame.status().frame;
    if (follower.frame.pose()) {
      all.insert_or_assign(name, *follower.frame.pose());
    } else if (!follower.is_pin) {
      const auto& offset = simulator.scene().colliders[static_cast<size_t>(follower.index)].offset;
      all.emplace(name, clothsim::frame_of(simulator.collider_pose(follower.index), offset));
    }
  }
  return all;
}

FrameFollower::Saved FrameFollower::save() const {
  Saved saved;
  for (const Follower& follower : followers_) saved.push_back(follower.memory);
  return saved;
}

void FrameFollower::restore(const Saved& saved, clothsim::Simulator& simulator) {
  forget_applied();
  for (size_t i = 0; i < followers_.size(); ++i) followers_[i].memory = saved.at(i);
  move(simulator);
}

void FrameFollower::forget_applied() {
  for (Follower& follower : followers_) {
    follower.applied.reset();
    follower.late = follower.has_begun = false;
  }
}

std::vector<FrameStatus> FrameFollower::status() const {
  std::vector<FrameStatus> all;
  for (const Follower& follower : followers_) all.push_back(follower.frame.status());
  return all;
}

}  // namespace clothsim_ros
