#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/ros/changes.h"
#include "clothsim/ros/jump_watch.h"
#include "clothsim/ros/speed_limit.h"
#include "clothsim/ros/tf_frame.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// Moves a simulator's colliders and pins along with their tf frames. Until a frame is seen they
/// stay where the scene puts them; when it is lost they stay where it was last.
class FrameFollower {
 public:
  /// `tf` must outlive this. For `jump_speed` see JumpWatch; pins follow at no more than it.
  FrameFollower(const clothsim::Scene&, TfListener& tf, double jump_speed);

  /// Reads the latest transforms.
  void look_up();

  /// What look_up() has found for the first time is put there, so that the next move() moves it
  /// from there. Tells of it.
  void take_up(clothsim::Simulator&, Changes&);

  /// Hands what look_up() found to the simulator, for its next frame. A collider takes the pose of
  /// its frame, a pin keeps the offset it had at the first transform. The first transform places a
  /// collider, later ones move it, but for jumps, which place it too.
  void move(clothsim::Simulator&);

  /// To be called when the simulator was reset: the next move is a first one again.
  void reset();

  /// Where the frames are, by name; those unknown to tf are where the scene has their collider, or
  /// left out.
  std::map<std::string, clothsim::Pose> frames(const clothsim::Simulator&) const;

  /// Tells of what move() goes by.
  void tell(Changes&) const;

  /// What is remembered of a frame. A run goes on with it.
  struct Memory {
    std::optional<clothsim::Vector3> pin_offset;  // [m] of the pin in the frame, once that is seen
    JumpWatch watch;
  };
  using Saved = std::vector<Memory>;
  Saved save() const;

  /// As move(), with what was remembered and colliders placed at once: to be called when the
  /// simulator went back to the state it had at save().
  void restore(const Saved&, clothsim::Simulator&);

  /// One for each collider and pin that has a frame.
  std::vector<FrameStatus> status() const;

 private:
  struct Follower {
    TfFrame frame;
    bool is_pin;
    int index;                              // of the scene's colliders or pins
    std::optional<clothsim::Pose> applied;  // the one that the simulator has
    bool late = false;                      // a pin is still on its way there
    Memory memory;
    bool has_begun = false;  // by take_up(), and has not moved yet
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
