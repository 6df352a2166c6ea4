#include "clothsim/ros/frame_follower.h"

namespace clothsim_ros {
namespace {

bool same(const clothsim::Pose& a, const clothsim::Pose& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs();
}

}  // namespace

FrameFollower::FrameFollower(const clothsim::Scene& scene, TfListener& tf) {
  const auto add = [&](const std::string& frame, bool is_pin, size_t index) {
    if (frame.empty()) return;
    followers_.push_back({TfFrame(frame, tf), is_pin, static_cast<int>(index), {}, {}});
  };
  for (size_t i = 0; i < scene.colliders.size(); ++i) add(scene.colliders[i].frame, false, i);
  for (size_t i = 0; i < scene.cloth.pinned.size(); ++i) add(scene.cloth.pinned[i].frame, true, i);
}

void FrameFollower::look_up() {
  for (Follower& follower : followers_) follower.frame.look_up();
}

void FrameFollower::move(clothsim::Simulator& simulator) {
  for (Follower& follower : followers_) {
    if (!follower.frame.pose()) continue;
    const clothsim::Pose& pose = *follower.frame.pose();
    const bool is_first = !follower.applied;
    if (!is_first && same(pose, *follower.applied)) continue;

    if (follower.is_pin) {
      if (!follower.pin_offset) {
        const auto& pin = simulator.scene().cloth.pinned[static_cast<size_t>(follower.index)];
        const int point = pin.row * simulator.cloth().columns + pin.column;
        const clothsim::Vector3 position = simulator.state().positions.row(point);
        follower.pin_offset = pose.orientation.conjugate() * (position - pose.position);
      } else {
        simulator.move_pin(follower.index, pose.position + pose.orientation * *follower.pin_offset);
      }
    } else if (is_first) {
      simulator.place_collider(follower.index, pose);
    } else {
      simulator.move_collider(follower.index, pose);
    }
    follower.applied = pose;
  }
}

void FrameFollower::tell(Changes& changes) const {
  for (const Follower& follower : followers_) changes.follow(follower.frame);
}

void FrameFollower::reset() {
  forget_applied();
  for (Follower& follower : followers_) follower.pin_offset.reset();
}

FrameFollower::Saved FrameFollower::save() const {
  Saved saved;
  for (const Follower& follower : followers_) saved.push_back(follower.pin_offset);
  return saved;
}

void FrameFollower::restore(const Saved& saved, clothsim::Simulator& simulator) {
  forget_applied();
  for (size_t i = 0; i < followers_.size(); ++i) followers_[i].pin_offset = saved.at(i);
  move(simulator);
}

void FrameFollower::forget_applied() {
  for (Follower& follower : followers_) follower.applied.reset();
}

std::vector<FrameStatus> FrameFollower::status() const {
  std::vector<FrameStatus> all;
  for (const Follower& follower : followers_) all.push_back(follower.frame.status());
  return all;
}

}  // namespace clothsim_ros
