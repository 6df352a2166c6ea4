#pragma once

#include <pybind11/numpy.h>
#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arrays.h"
#include "clothsim/run/driven_frames.h"
#include "clothsim/run/motion_player.h"
#include "clothsim/run/report.h"
#include "clothsim/scene/robot_models.h"
#include "clothsim/simulation/simulator.h"
#include "gate.h"
#include "signal_watch.h"

namespace clothsim_python {

namespace py = pybind11;

/// A scene from Python.
struct SceneObject {
  clothsim::Scene scene;
  YAML::Node yaml;                     // with the overrides
  std::string file;                    // empty: none
  std::filesystem::path folder;        // for relative paths of files
  std::vector<std::string> overrides;  // "key=value"
};

/// Joint values by the name of a robot.
using RobotJoints = std::map<std::string, clothsim::JointValues>;

/// A simulation with its motions, frames and robots. Views of its state keep it alive, even when
/// its Simulation has another run.
struct Run {
  explicit Run(const SceneObject&);
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  /// Plays motions, moves frames and steps. Throws their exceptions.
  void step(int frames);

  void reset();

  /// The robots of the scene, by name; read at the first call. Throws InvalidValue.
  const std::map<std::string, clothsim::RobotModel>& robots();

  const std::shared_ptr<const SceneObject> scene;
  clothsim::Simulator simulator;
  clothsim::MotionPlayer motions;  // of the scene
  clothsim::DrivenFrames frames;   // moved by the program
  RobotJoints joints;              // last set by the program
  clothsim::RunReport report;
  SignalWatch* watch = nullptr;    // of the running call
  std::shared_ptr<void> pictures;  // data of the drawing module

 private:
  std::optional<std::map<std::string, clothsim::RobotModel>> robots_;
};

/// clothsim.Simulator. Any thread may call; calls take turns.
class Simulation {
 public:
  explicit Simulation(const SceneObject& scene) : run_(std::make_shared<Run>(scene)) {}
  explicit Simulation(std::shared_ptr<Run> run) : run_(std::move(run)) {}

  /// Calls `action` with the run while no other thread uses it, holding the GIL.
  template <class Action>
  auto with(Action&& action) {
    const Gate::Visit visit(gate_);
    return action(*run_);
  }

  /// The same, without the GIL.
  template <class Action>
  auto compute_with(Action&& action) {
    const Gate::Visit visit(gate_);
    const py::gil_scoped_release release;
    return action(*run_);
  }

  void load(const SceneObject&);
  clothsim::StepReport step(int frames, const py::object& targets);

  Gate& gate() { return gate_; }
  const std::shared_ptr<Run>& run() const { return run_; }

 private:
  Gate gate_;
  std::shared_ptr<Run> run_;
};

/// Throws InvalidValue, keys from the frame on, for invalid targets, and for frames that `run` does
/// not use.
void check_targets(const Targets&, const Run& run);

/// Throws InvalidValue unless `frames` is at least 1.
void check_frames(int frames);

}  // namespace clothsim_python
