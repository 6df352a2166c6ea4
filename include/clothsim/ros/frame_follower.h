#pragma once

#include <ros/time.h>
#include <tf2/buffer_core.h>
#include <tf2_ros/transform_listener.h>

#include <optional>
#include <string>
#include <vector>

#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// What is known of a tf frame that carries a collider or a pin.
struct FrameStatus {
  std::string frame;
  bool seen = false;  // a transform to the world came
  bool lost = false;  // seen, but nothing newer came for a while
  double age = 0;     // [s] of the latest transform; 0 for a static one
};

/// Moves a simulator's colliders and pins along with their tf frames. Until a frame is seen they
/// stay where the scene puts them; when it is lost they stay where it was last.
class FrameFollower {
 public:
  /// Listens to tf only if the scene names a frame.
  FrameFollower(const clothsim::Scene&, std::string world_frame);

  /// Reads the latest transforms.
  void look_up();

  /// Hands what look_up() found to the simulator, for its next frame. A collider takes the pose of
  /// its frame, a pin keeps the offset it had at the first transform. The first transform places a
  /// collider, later ones move it.
  void move(clothsim::Simulator&);

  /// To be called when the simulator was reset: the next move is a first one again.
  void reset();

  /// One for each collider and pin that has a frame.
  std::vector<FrameStatus> status() const;

 private:
  struct Follower {
    FrameStatus status;
    bool is_pin;
    int index;                              // of the scene's colliders or pins
    std::optional<clothsim::Pose> latest;   // of the frame in the world
    ros::Time stamp;                        // of that; zero: a static transform
    std::optional<clothsim::Pose> applied;  // the one that the simulator has
    clothsim::Vector3 pin_offset{0, 0, 0};  // [m] of the pin in the frame
  };

  void look_up(Follower&);

  std::string world_frame_;
  std::vector<Follower> followers_;
  tf2::BufferCore buffer_;
  std::optional<tf2_ros::TransformListener> listener_;
};

}  // namespace clothsim_ros
