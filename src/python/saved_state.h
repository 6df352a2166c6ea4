#pragma once

#include <memory>
#include <string>

#include "simulation.h"

namespace clothsim_python {

/// clothsim.SavedState: a copy of the full state, and its scene.
struct SavedState {
  std::shared_ptr<const SceneObject> scene;
  clothsim::LiveSpec values;  // at the time of the copy
  std::shared_ptr<const clothsim::Simulator::Saved> saved;
  clothsim::DrivenFrames frames;
  RobotJoints joints;
  clothsim::MotionPlayer motions;
};

SavedState save(const Run&);

/// Throws InvalidValue for a state of another scene, without a change.
void restore(Run&, const SavedState&);

// The bytes that pickle stores beside the scene. A run and a state restored from them continue with
// the same bits as the originals. Bytes from elsewhere, or from another version, throw
// InvalidValue.

std::string bytes_of(const SavedState&);
std::string bytes_of(const Run&);
std::string bytes_of(const clothsim::StepReport&);

SavedState state_from(const SceneObject&, const std::string& bytes);
std::shared_ptr<Run> run_from(const SceneObject&, const std::string& bytes);
clothsim::StepReport report_from(const std::string& bytes);

}  // namespace clothsim_python
