#include "clothsim/run/motion_player.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "clothsim/model/checks.h"
#include "clothsim/scene/motion_files.h"

namespace clothsim {
namespace {

/// Runs `action`; the key of an entry goes before the keys of its errors.
template <class Action>
void in_motions(std::size_t item, Action&& action) {
  inside("motions", [&] { inside(std::to_string(item), action); });
}

}  // namespace

template <class Action>
std::size_t MotionPlayer::Track<Action>::sort_in(Due<Action> due) {
  const auto is_before = [](long long frame, const Due<Action>& entry) {
    return frame < entry.frame;
  };
  const auto place = std::upper_bound(entries.begin(), entries.end(), due.frame, is_before);
  const auto index = static_cast<std::size_t>(place - entries.begin());
  entries.insert(place, std::move(due));
  return index;
}

MotionPlayer::MotionPlayer(const Simulator& simulator, const std::filesystem::path& folder) {
  const std::vector<MotionEntry>& motions = simulator.scene().motions;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    in_motions(i, [&] {
      const auto* file = std::get_if<KeyFrameFile>(&motions[i].action);
      if (!file) return sort_in(simulator, motions[i], i);
      inside("file", [&] {
        for (const MotionEntry& entry : read_key_frames(folder / file->file, file->frame))
          sort_in(simulator, entry, i);
      });
    });
  }
}

void MotionPlayer::sort_in(const Simulator& simulator, const MotionEntry& entry, std::size_t item) {
  const long long frame = std::llround(entry.time / simulator.frame_duration());
  duration_ = std::max(duration_, entry.time);
  const auto* key = std::get_if<KeyFrame>(&entry.action);
  if (!key) {
    events_.sort_in({frame, item, entry.action});
    return;
  }
  const std::size_t place = keys_[key->frame].sort_in({frame, item, key->target});
  const std::vector<Due<FrameTarget>>& track = keys_[key->frame].entries;
  if (place == 0 || track[place - 1].frame < frame) return;
  throw InvalidValue({"time"},
                     to_text(entry.time) +
                         ", in the same frame of simulation as a key frame of item " +
                         std::to_string(track[place - 1].item),
                     "one frame of simulation between two key frames at least");
}

void MotionPlayer::play(Simulator& simulator) {
  for (auto& [frame, track] : keys_) set_target(frame, track, simulator);
  while (events_.next < events_.entries.size() && events_.entries[events_.next].frame <= frame_) {
    const Due<MotionAction>& due = events_.entries[events_.next++];
    in_motions(due.item, [&] { act(due.action, simulator); });
  }
  driven_.move(simulator);
  ++frame_;
}

void MotionPlayer::set_target(const std::string& frame, Track<FrameTarget>& track,
                              Simulator& simulator) {
  const auto& keys = track.entries;
  if (frame_ == 0 && keys[0].frame == 0) {
    driven_.place(frame, keys[0].action.pose, keys[0].action.twist.value_or(Twist()), simulator);
    track.next = 1;
  }
  const long long begin = track.next == 0 ? 0 : keys[track.next - 1].frame;
  if (track.next == keys.size() || frame_ != begin) return;
  const Due<FrameTarget>& key = keys[track.next++];
  driven_.set_targets({{frame, key.action}}, static_cast<int>(key.frame - frame_), simulator);
}

void MotionPlayer::act(const MotionAction& action, Simulator& simulator) {
  if (const auto* points = std::get_if<AttachPoints>(&action)) {
    attach(*points, simulator);
  } else if (const auto* lets_go = std::get_if<DetachPoints>(&action)) {
    const auto grip = simulator.grips().find(lets_go->frame);
    if (grip == simulator.grips().end()) return;  // torn off
    std::vector<int> held = lets_go->points;
    std::vector<Grip::HeldBody> bodies;
    if (held.empty()) {
      for (const Grip::Held& h : grip->second.held) held.push_back(h.point);
      bodies = grip->second.bodies;
    }
    if (!held.empty()) simulator.detach(held);
    for (const Grip::HeldBody& b : bodies) simulator.detach_body(static_cast<int>(b.leader));
  } else if (const auto* change = std::get_if<SwitchCollider>(&action)) {
    const std::vector<ColliderSpec>& colliders = simulator.scene().colliders;
    for (std::size_t i = 0; i < colliders.size(); ++i) {
      if (colliders[i].name == change->collider)
        simulator.enable_collider(static_cast<int>(i), change->enabled);
    }
  } else {
    LiveSpec live = live_values(simulator.scene());
    inside("set", [&] {
      std::get<ChangeValues>(action).change(live);
      simulator.set(live);
    });
  }
}

void MotionPlayer::attach(const AttachPoints& asked, Simulator& simulator) const {
  const Pose* driven = driven_.pose(asked.frame);
  const std::optional<Pose> pose = driven ? *driven : followed_pose(asked.frame, simulator);
  if (!pose) {
    throw InvalidValue({"attach"}, '"' + asked.frame + '"',
                       "a frame that has set out for a key frame, or that a collider follows");
  }
  if (!asked.body.empty()) {
    simulator.attach_body(*simulator.body_named(asked.body), asked.frame, *pose);
    return;
  }
  std::vector<int> points = asked.points;
  if (points.empty()) points = simulator.free_points_near(pose->position, asked.radius);
  simulator.attach(asked.frame, *pose, points, {asked.tear_force, asked.strength});
}

}  // namespace clothsim
