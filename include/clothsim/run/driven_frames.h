#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/run/pose_trajectory.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim {

/// A frame that reaches its target some frames of simulation later.
class FrameMotion {
 public:
  explicit FrameMotion(const Pose& pose = {}, const Twist& twist = {})
      : pose_(pose), twist_(twist), trajectory_(pose) {}

  /// Starts towards `target`, to arrive after `frames` frames of `frame_duration` [s] each.
  void set_target(const FrameTarget& target, int frames, double frame_duration);

  /// Advances to the end of the next frame of simulation and returns the pose there. After its
  /// arrival the frame is at rest.
  const Pose& advance();

  bool has_arrived() const { return done_ == frames_; }
  const Pose& pose() const { return pose_; }
  const Twist& twist() const { return twist_; }

  /// For an archive that writes or reads its arguments.
  template <class Archive>
  void serialize(Archive& archive) {
    archive(pose_, twist_, trajectory_, frames_, done_);
  }

 private:
  Pose pose_;
  Twist twist_;
  PoseTrajectory trajectory_;
  int frames_ = 0;  // until the target
  int done_ = 0;    // of `frames_`
};

/// Frames that a program moves, without tf, with their followers in a simulator: colliders, pins
/// and attached points. A new frame starts at the start in its target, else at its collider or
/// attached points, else at the target itself. Pins keep the offset that they have in the frame
/// then. Belongs to one simulator; a copy taken together with Simulator::save() continues with the
/// same bits.
class DrivenFrames {
 public:
  /// Moves frames, by name, to their targets within `frames` >= 1 frames of simulation. Where a
  /// target has a start, the followers are put there at once. Throws InvalidValue without a change;
  /// keys begin with the frame.
  void set_targets(const std::map<std::string, FrameTarget>& targets, int frames, Simulator&);

  /// Puts a frame and its followers at a pose. `twist` is the frame's velocity at the start of the
  /// next set_targets(). Throws InvalidValue without a change.
  void place(const std::string& frame, const Pose&, const Twist&, Simulator&);

  /// Passes the next poses to the simulator: to be called before each Simulator::step().
  void move(Simulator&);

  /// The pose of the frame; null for one without a target so far.
  const Pose* pose(const std::string& frame) const;

  /// To be called after the simulator was reset or loaded.
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

/// The pose of a frame by the points attached to it, else by the first collider that follows it, or
/// of the body of that name; empty: there is none.
std::optional<Pose> followed_pose(const std::string& frame, const Simulator&);

/// Throws InvalidValue for the name of a rigid body.
void check_no_body(const std::string& frame, const Simulator&);

/// The frames that the scene's colliders and pins follow, or that points are attached to.
std::vector<std::string> followed_frames(const Simulator&);

}  // namespace clothsim
