#pragma once

#include <optional>
#include <vector>

#include "clothsim/ros/changes.h"
#include "clothsim/ros/tf_frame.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// Moves a simulator's colliders and pins along with their tf frames. Until a frame is seen they
/// stay where the scene puts them; when it is lost they stay where it was last.
class FrameFollower {
 public:
  /// Makes tf listen only if the scene names a frame. `tf` must outlive this.
  FrameFollower(const clothsim::Scene&, TfListener& tf);

  /// Reads the latest transforms.
  void look_up();

  /// Hands what look_up() found to the simulator, for its next frame. A collider takes the pose of
  /// its frame, a pin keeps the offset it had at the first transform. The first transform places a
  /// collider, later ones move it.
  void move(clothsim::Simulator&);

  /// To be called when the simulator was reset: the next move is a first one again.
  void reset();

  /// Tells of what move() goes by.
  void tell(Changes&) const;

  /// Where pins are in their frames [m]; empty until a frame is seen. A run goes on with these.
  using Saved = std::vector<std::optional<clothsim::Vector3>>;
  Saved save() const;

  /// As move(), with pins where they were in their frames and colliders placed at once: to be
  /// called when the simulator went back to the state it had at save().
  void restore(const Saved&, clothsim::Simulator&);

  /// One for each collider and pin that has a frame.
  std::vector<FrameStatus> status() const;

 private:
  struct Follower {
    TfFrame frame;
    bool is_pin;
    int index;                                    // of the scene's colliders or pins
    std::optional<clothsim::Pose> applied;        // the one that the simulator has
    std::optional<clothsim::Vector3> pin_offset;  // [m] of the pin in the frame
  };

  void forget_applied();

  std::vector<Follower> followers_;
};

}  // namespace clothsim_ros
