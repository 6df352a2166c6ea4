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

/// A scene as Python gave it.
struct SceneObject {
  clothsim::Scene scene;
  YAML::Node yaml;                     // with what was overridden
  std::string file;                    // empty: there is none
  std::filesystem::path folder;        // that its files are in
  std::vector<std::string> overrides;  // "key=value"
};

/// By the name of a robot.
using RobotJoints = std::map<std::string, clothsim::JointValues>;

/// A simulation and what belongs to it. Views of its state keep it alive, also when its Simulation
/// has taken another one.
struct Run {
  explicit Run(const SceneObject&);
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  /// Plays motions, moves frames and steps. Throws what these do.
  void step(int frames);

  void reset();

  /// The scene's, by their names; read when they are first asked for. Throws InvalidValue.
  const std::map<std::string, clothsim::RobotModel>& robots();

  const std::shared_ptr<const SceneObject> scene;
  clothsim::Simulator simulator;
  clothsim::MotionPlayer motions;  // of the scene
  clothsim::DrivenFrames frames;   // that the program moves
  RobotJoints joints;              // as the program told them last
  clothsim::RunReport report;
  SignalWatch* watch = nullptr;    // of the call under way
  std::shared_ptr<void> pictures;  // what the module that draws keeps with it

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

/// Throws InvalidValue, keys from the frame on, for targets that cannot be, and for frames that
/// nothing of `run` knows.
void check_targets(const Targets&, const Run& run);

/// Throws InvalidValue unless `frames` is at least 1.
void check_frames(int frames);

}  // namespace clothsim_python
