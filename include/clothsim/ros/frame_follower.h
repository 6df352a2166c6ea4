#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/ros/changes.h"
#include "clothsim/ros/jumps.h"
#include "clothsim/ros/tf_frame.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// Moves a simulator's colliders and pins with their tf frames. Without a transform so far they
/// stay at their poses in the scene; when the frame is lost they stay at their last poses.
class FrameFollower {
 public:
  /// `tf` must outlive this. `jump_speed`: see JumpWatch; it bounds the speed of pins.
  FrameFollower(const clothsim::Scene&, TfListener& tf, double jump_speed);

  /// Reads the latest transforms.
  void look_up();

  /// Puts followers at the poses that look_up() has found for the first time, so that the next
  /// move() starts there. Publishes them.
  void take_up(clothsim::Simulator&, Changes&);

  /// Passes the poses of look_up() to the simulator, for its next frame. A collider takes the pose
  /// of its frame, a pin keeps the offset it had at the first transform. The first transform places
  /// a collider, later ones move it, except for jumps, which place it, too.
  void move(clothsim::Simulator&);

  /// To be called when the simulator was reset: the next move is a first one again.
  void reset();

  /// The poses of the frames, by name; a frame unknown to tf has its collider's pose in the scene,
  /// or is left out.
  std::map<std::string, clothsim::Pose> frames(const clothsim::Simulator&) const;

  /// Publishes the transforms that move() uses.
  void tell(Changes&) const;

  /// State of a frame that a run needs to continue.
  struct Memory {
    std::optional<clothsim::Vector3> pin_offset;  // [m] of the pin in the frame, once seen
    JumpWatch watch;
  };
  using Saved = std::vector<Memory>;
  Saved save() const;

  /// As move(), with the saved state and colliders placed at once: to be called when the simulator
  /// was restored to its state at save().
  void restore(const Saved&, clothsim::Simulator&);

  /// The status of each collider and pin that has a frame.
  std::vector<FrameStatus> status() const;

 private:
  struct Follower {
    TfFrame frame;
    bool is_pin;
    int index;                              // of the scene's colliders or pins
    std::optional<clothsim::Pose> applied;  // the pose in the simulator
    bool late = false;                      // a pin has not reached it yet
    Memory memory;
    bool has_begun = false;  // by take_up(), without a move so far
  };

  void move(Follower&, clothsim::Simulator&);
  void move_pin(Follower&, clothsim::Simulator&);
  static void move_collider(Follower&, clothsim::Simulator&);
  void forget_applied();

  JumpWatch fresh_watch_;
  SpeedLimit speed_limit_;
  std::vector<Follower> followers_;
};

}  // namespace clothsim_ros
