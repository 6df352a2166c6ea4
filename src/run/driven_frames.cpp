#include "clothsim/run/driven_frames.h"

#include <cassert>
#include <set>
#include <utility>

#include "clothsim/model/checks.h"

namespace clothsim {
namespace {

Vector3 pin_position(const Simulator& simulator, std::size_t pin) {
  const Pin& p = simulator.scene().cloth.pinned[pin];
  return simulator.state().positions.row(p.row * simulator.cloth().columns + p.column).transpose();
}

}  // namespace

void FrameMotion::set_target(const FrameTarget& target, int frames, double frame_duration) {
  assert(frames >= 1);
  if (target.start) *this = FrameMotion(*target.start);
  trajectory_ = PoseTrajectory(pose_, twist_, target.pose, target.twist, frames * frame_duration);
  frames_ = frames;
  done_ = 0;
}

const Pose& FrameMotion::advance() {
  if (has_arrived()) {
    twist_ = {};
    return pose_;
  }
  const double share = static_cast<double>(++done_) / frames_;
  pose_ = trajectory_.pose_at(share);
  twist_ = trajectory_.twist_at(share);
  return pose_;
}

DrivenFrames::Driven& DrivenFrames::take(const std::string& frame, const Pose& if_new,
                                         Simulator& simulator) {
  const auto known = driven_.find(frame);
  if (known != driven_.end()) return known->second;
  Driven driven{FrameMotion(if_new), {}};
  const Scene& scene = simulator.scene();
  for (std::size_t i = 0; i < scene.colliders.size(); ++i) {
    if (scene.colliders[i].frame == frame) driven.followers.push_back({false, static_cast<int>(i)});
  }
  for (std::size_t i = 0; i < scene.cloth.pinned.size(); ++i) {
    if (scene.cloth.pinned[i].frame != frame) continue;
    const Vector3 offset = to_local(if_new, pin_position(simulator, i));
    driven.followers.push_back({true, static_cast<int>(i), offset});
  }
  put(driven, if_new, simulator);
  return driven_.emplace(frame, std::move(driven)).first->second;
}

void DrivenFrames::put(const Driven& driven, const Pose& pose, Simulator& simulator) {
  for (const Follower& follower : driven.followers) {
    if (follower.is_pin) continue;
    // A collider that is there already is left alone.
    const Pose& now = simulator.collider_pose(follower.index);
    const auto index = static_cast<std::size_t>(follower.index);
    const Pose wanted = pose * simulator.scene().colliders[index].offset;
    if (!same(now, wanted)) simulator.place_collider(follower.index, pose);
  }
}

void DrivenFrames::place(const std::string& frame, const Pose& pose, const Twist& twist,
                         Simulator& simulator) {
  check_no_body(frame, simulator);
  inside(frame, [&] { check({pose, twist}); });
  Driven& driven = take(frame, pose, simulator);
  driven.motion = FrameMotion(pose, twist);
  put(driven, pose, simulator);
}

void DrivenFrames::set_targets(const std::map<std::string, FrameTarget>& targets, int frames,
                               Simulator& simulator) {
  if (frames < 1) {
    throw InvalidValue({"frames"}, std::to_string(frames), "a whole number of at least 1");
  }
  for (const auto& [frame, target] : targets) {
    check_no_body(frame, simulator);
    inside(frame, [&, &t = target] { check(t); });
  }
  for (const auto& [frame, target] : targets) {
    const Pose start =
        target.start ? *target.start : followed_pose(frame, simulator).value_or(target.pose);
    Driven& driven = take(frame, start, simulator);
    if (target.start) put(driven, start, simulator);
    driven.motion.set_target(target, frames, simulator.frame_duration());
  }
}

void DrivenFrames::move(Simulator& simulator) {
  for (auto& [frame, driven] : driven_) {
    const bool stays = driven.motion.has_arrived();
    const Pose& pose = driven.motion.advance();
    if (stays) continue;
    for (const Follower& follower : driven.followers) {
      if (follower.is_pin) {
        simulator.move_pin(follower.index, pose.position + pose.orientation * follower.offset);
      } else {
        simulator.move_collider(follower.index, pose);
      }
    }
    if (simulator.grips().count(frame) > 0) simulator.move_grip(frame, pose);
  }
}

const Pose* DrivenFrames::pose(const std::string& frame) const {
  const auto known = driven_.find(frame);
  return known == driven_.end() ? nullptr : &known->second.motion.pose();
}

std::optional<Pose> followed_pose(const std::string& frame, const Simulator& simulator) {
  const auto grip = simulator.grips().find(frame);
  if (grip != simulator.grips().end() && !grip->second.on_body) return grip->second.pose;
  const std::vector<ColliderSpec>& colliders = simulator.scene().colliders;
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    const auto index = static_cast<int>(i);
    if (simulator.is_body(index) && colliders[i].name == frame) {
      return simulator.collider_pose(index);
    }
    if (colliders[i].frame != frame) continue;
    return frame_of(simulator.collider_pose(index), colliders[i].offset);
  }
  return std::nullopt;
}

void check_no_body(const std::string& frame, const Simulator& simulator) {
  if (!simulator.body_named(frame)) return;
  throw InvalidValue({frame}, "a rigid body", "a frame that a program moves");
}

std::vector<std::string> followed_frames(const Simulator& simulator) {
  std::set<std::string> frames;
  for (const ColliderSpec& collider : simulator.scene().colliders) frames.insert(collider.frame);
  for (const Pin& pin : simulator.scene().cloth.pinned) frames.insert(pin.frame);
  for (const auto& [frame, grip] : simulator.grips()) {
    if (!grip.on_body) frames.insert(frame);
  }
  frames.erase("");
  return {frames.begin(), frames.end()};
}

}  // namespace clothsim
