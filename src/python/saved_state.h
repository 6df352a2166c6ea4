#pragma once

#include <memory>
#include <string>

#include "simulation.h"

namespace clothsim_python {

/// clothsim.SavedState: a copy of all that moves, and its scene.
struct SavedState {
  std::shared_ptr<const SceneObject> scene;
  clothsim::LiveSpec values;  // when it was made
  std::shared_ptr<const clothsim::Simulator::Saved> saved;
  clothsim::DrivenFrames frames;
  RobotJoints joints;
  clothsim::MotionPlayer motions;
};

SavedState save(const Run&);

/// Throws InvalidValue for a state of another scene, and changes nothing.
void restore(Run&, const SavedState&);

// What pickle keeps beside the scene. Run and state that are made of it go on to the same bits as
// those that it was made of. Bytes that were not made so, by this version, throw InvalidValue.

std::string bytes_of(const SavedState&);
std::string bytes_of(const Run&);
std::string bytes_of(const clothsim::StepReport&);

SavedState state_from(const SceneObject&, const std::string& bytes);
std::shared_ptr<Run> run_from(const SceneObject&, const std::string& bytes);
clothsim::StepReport report_from(const std::string& bytes);

}  // namespace clothsim_python
