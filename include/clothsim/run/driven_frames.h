#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "clothsim/run/pose_way.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim {

/// A frame that is told where to be some frames of simulation later.
class FrameMotion {
 public:
  explicit FrameMotion(const Pose& pose = {}, const Twist& twist = {})
      : pose_(pose), twist_(twist), way_(pose) {}

  /// Sets out for `target`, to be there after `frames` frames of `frame_duration` [s] each.
  void set_target(const FrameTarget& target, int frames, double frame_duration);

  /// Goes on to the end of the next frame of simulation. Once there it stays, at rest.
  const Pose& advance();

  bool has_arrived() const { return done_ == frames_; }
  const Pose& pose() const { return pose_; }
  const Twist& twist() const { return twist_; }

  /// For an archive that writes or reads its arguments.
  template <class Archive>
  void serialize(Archive& archive) {
    archive(pose_, twist_, way_, frames_, done_);
  }

 private:
  Pose pose_;
  Twist twist_;
  PoseWay way_;
  int frames_ = 0;  // of the way
  int done_ = 0;    // of those
};

/// Frames that a program moves, without tf, and with them what follows them in a simulator: its
/// colliders, pins and attached points. A frame that is new starts where its target says, else
/// where its collider or what is attached to it is, else at the target itself. Pins keep the offset
/// that they have in it then. Belongs to one simulator; a copy that is taken together with
/// Simulator::save() goes on to the same bits.
class DrivenFrames {
 public:
  /// Has frames, by name, be at their targets after `frames` >= 1 frames of simulation. Where a
  /// target has a start, what follows is put there at once. Throws InvalidValue and changes
  /// nothing; keys begin with the frame.
  void set_targets(const std::map<std::string, FrameTarget>& targets, int frames, Simulator&);

  /// Puts a frame at a pose, with what follows it. It has `twist` for the next set_targets().
  /// Throws InvalidValue and changes nothing.
  void place(const std::string& frame, const Pose&, const Twist&, Simulator&);

  /// Hands the next poses to the simulator: to be called before each Simulator::step().
  void move(Simulator&);

  /// Where the frame is; null for one that was never told.
  const Pose* pose(const std::string& frame) const;

  /// To be called when the simulator was reset or loaded anew.
  void reset() { driven_.clear(); }

  /// For an archive that writes or reads its arguments.
  template <class Archive>
  void serialize(Archive& archive) {
    archive(driven_);
  }

 private:
  struct Follower {
    bool is_pin = false;
    int index = 0;               // of the scene's colliders or pins
    Vector3 offset = {0, 0, 0};  // of the pin in the frame [m]

    template <class Archive>
    void serialize(Archive& archive) {
      archive(is_pin, index, offset);
    }
  };
  struct Driven {
    FrameMotion motion;
    std::vector<Follower> followers;

    template <class Archive>
    void serialize(Archive& archive) {
      archive(motion, followers);
    }
  };

  static void put(const Driven&, const Pose&, Simulator&);
  Driven& take(const std::string& frame, const Pose& if_new, Simulator&);

  std::map<std::string, Driven> driven_;  // by frame
};

/// Where the points attached to a frame say that it is, else the first collider that follows it;
/// empty: neither is there.
std::optional<Pose> followed_pose(const std::string& frame, const Simulator&);

/// The frames that something of the scene follows, or points are attached to.
std::vector<std::string> followed_frames(const Simulator&);

}  // namespace clothsim
