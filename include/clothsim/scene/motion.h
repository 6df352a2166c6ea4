#pragma once

#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "clothsim/shapes/collider.h"

namespace clothsim {

struct LiveSpec;

/// Velocity of a frame, in the world.
struct Twist {
  Vector3 linear{0, 0, 0};   // of its origin [m/s]
  Vector3 angular{0, 0, 0};  // [rad/s]
};

/// A pose for a frame to move to.
struct FrameTarget {
  Pose pose;
  std::optional<Twist> twist = {};  // at the target; empty: constant velocity on the way
  std::optional<Pose> start = {};   // empty: the present pose
};

/// A frame is at a pose at a time.
struct KeyFrame {
  std::string frame;
  FrameTarget target;  // without a start
};

/// A CSV or NPZ file of key frames of one frame.
struct KeyFrameFile {
  std::string frame;
  std::string file;  // relative to the folder of the scene
};

/// Points, or a rigid body, follow a frame from this time on, as by Simulator::attach() and
/// attach_body().
struct AttachPoints {
  std::string frame;
  std::vector<int> points;           // empty: the free points within `radius` of the frame
  double radius = 0;                 // [m]
  std::optional<double> tear_force;  // [N]
  std::optional<double> strength;    // [N]
  std::string body = {};             // empty: the points
};

/// A frame releases points.
struct DetachPoints {
  std::string frame;
  std::vector<int> points;  // empty: all, and its bodies
};

struct SwitchCollider {
  std::string collider;
  bool enabled = true;
};

/// Values that change from this time on. Throws InvalidValue for values the scene does not have.
struct ChangeValues {
  std::function<void(LiveSpec&)> change;
};

using MotionAction =
    std::variant<KeyFrame, KeyFrameFile, AttachPoints, DetachPoints, SwitchCollider, ChangeValues>;

/// A scheduled event of a run.
struct MotionEntry {
  double time = 0;  // [s] from the start of the run; without meaning for a file
  MotionAction action;
};

}  // namespace clothsim
