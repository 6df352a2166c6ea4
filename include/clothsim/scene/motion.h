#pragma once

#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "clothsim/shapes/collider.h"

namespace clothsim {

struct LiveSpec;

/// How fast a frame moves, in the world.
struct Twist {
  Vector3 linear{0, 0, 0};   // of its origin [m/s]
  Vector3 angular{0, 0, 0};  // [rad/s]
};

/// Where a frame is to be.
struct FrameTarget {
  Pose pose;
  std::optional<Twist> twist = {};  // that it arrives with; empty: it moves evenly
  std::optional<Pose> start = {};   // empty: from where it is
};

/// A frame is at a pose.
struct KeyFrame {
  std::string frame;
  FrameTarget target;  // without a start
};

/// A CSV or NPZ file of key frames of one frame.
struct KeyFrameFile {
  std::string frame;
  std::string file;  // relative to the folder of the scene
};

/// Points follow a frame from now on, as by Simulator::attach().
struct AttachPoints {
  std::string frame;
  std::vector<int> points;           // empty: those free within `radius` of the frame
  double radius = 0;                 // [m]
  std::optional<double> tear_force;  // [N]
  std::optional<double> strength;    // [N]
};

/// A frame lets go.
struct DetachPoints {
  std::string frame;
  std::vector<int> points;  // empty: of all
};

struct SwitchCollider {
  std::string collider;
  bool enabled = true;
};

/// Values that change from now on. Throws InvalidValue for what is none of the scene's.
struct ChangeValues {
  std::function<void(LiveSpec&)> change;
};

using MotionAction =
    std::variant<KeyFrame, KeyFrameFile, AttachPoints, DetachPoints, SwitchCollider, ChangeValues>;

/// What happens in a run without anybody there.
struct MotionEntry {
  double time = 0;  // [s] from the start of the run; of no meaning for a file
  MotionAction action;
};

}  // namespace clothsim
