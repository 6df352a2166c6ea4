#include "saved_state.h"

#include "archive.h"

namespace clothsim_python {
namespace {

using Saved = clothsim::Simulator::Saved;

/// Calls `read`; its errors are reported as errors in the bytes.
template <class Read>
void check_bytes(Read&& read) {
  try {
    read();
  } catch (const cereal::Exception&) {
    throw clothsim::InvalidValue({"state"}, "bytes that end too early or are none of these",
                                 "those that this version of clothsim has pickled");
  }
}

/// Reads a state from bytes for a fresh `run`, and gives the run the state's live values.
SavedState read_state(const std::string& bytes, Run& run) {
  clothsim::LiveSpec values;
  check_bytes([&] { from_bytes(bytes, values); });
  run.simulator.set(values);
  const auto saved = std::make_shared<Saved>(*run.simulator.save());
  const std::size_t pins = saved->pin_targets.size();
  SavedState state{run.scene, values, saved, run.frames, run.joints, run.motions};
  check_bytes(
      [&] { from_bytes(bytes, values, *saved, state.frames, state.joints, state.motions); });
  const Eigen::Index points = run.simulator.cloth().num_points();
  const clothsim::State& moved = saved->state;
  if (moved.positions.rows() != points || moved.velocities.rows() != points ||
      saved->pin_targets.size() != pins ||
      saved->collider_wrenches.size() != saved->colliders.size()) {
    throw clothsim::InvalidValue({"state"}, "that of another scene", "one of this scene");
  }
  for (const auto& [frame, grip] : saved->grips.all()) {
    for (const clothsim::Grip::Held& held : grip.held) {
      if (held.point >= 0 && held.point < points) continue;
      throw clothsim::InvalidValue({"state"}, "that of another scene", "one of this scene");
    }
  }
  saved->grips.for_each_held(
      [&](int, int point, const clothsim::Vector3&) { saved->cloth.inv_mass[point] = 0; });
  return state;
}

}  // namespace

SavedState save(const Run& run) {
  const clothsim::Simulator& simulator = run.simulator;
  return {run.scene,  live_values(simulator.scene()), simulator.save(), run.frames, run.joints,
          run.motions};
}

void restore(Run& run, const SavedState& state) {
  run.simulator.restore(*state.saved);
  run.frames = state.frames;
  run.joints = state.joints;
  run.motions = state.motions;
}

std::string bytes_of(const SavedState& state) {
  return to_bytes(state.values, *state.saved, state.frames, state.joints, state.motions);
}

std::string bytes_of(const Run& run) {
  return to_bytes(bytes_of(save(run)), run.report, run.simulator.measures_wrenches());
}

std::string bytes_of(const clothsim::StepReport& report) { return to_bytes(report); }

SavedState state_from(const SceneObject& scene, const std::string& bytes) {
  Run fresh(scene);
  return read_state(bytes, fresh);
}

std::shared_ptr<Run> run_from(const SceneObject& scene, const std::string& bytes) {
  const auto run = std::make_shared<Run>(scene);
  std::string state;
  bool measures_wrenches = false;
  check_bytes([&] { from_bytes(bytes, state, run->report, measures_wrenches); });
  run->simulator.measure_wrenches(measures_wrenches);
  restore(*run, read_state(state, *run));
  return run;
}

clothsim::StepReport report_from(const std::string& bytes) {
  clothsim::StepReport report;
  check_bytes([&] { from_bytes(bytes, report); });
  return report;
}

}  // namespace clothsim_python
