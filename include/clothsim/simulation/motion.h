#pragma once

#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "clothsim/model/cloth_spec.h"
#include "clothsim/simulation/pose_way.h"

namespace clothsim {

struct SimulationSpec;

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

/// Values that change while the cloth moves; empty: stays as it is.
struct LiveValues {
  std::optional<double> ks, density, damping;
  std::optional<std::optional<double>> strain_limit;
  std::array<std::optional<bool>, 3> springs;
  std::optional<Vector3> gravity;  // [m/s^2]

  void apply(Material&, SimulationSpec&) const;
};

using MotionAction =
    std::variant<KeyFrame, KeyFrameFile, AttachPoints, DetachPoints, SwitchCollider, LiveValues>;

/// What happens in a run without anybody there.
struct MotionEntry {
  double time = 0;  // [s] from the start of the run; of no meaning for a file
  MotionAction action;
};

}  // namespace clothsim
