#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/simulation/simulator.h"

namespace clothsim {

/// Exit codes of the programs that run a scene.
enum ExitCode { done = 0, bad_input = 1, diverged = 2, interrupted = 130 };

struct RunOptions {
  std::string scene;
  std::optional<double> seconds;  // empty: the duration of the motions
  std::optional<double> every;    // [s] between kept frames; empty: the last frame only
  std::vector<std::string> overrides;
  std::filesystem::path output;  // folder; empty: no files
  std::filesystem::path from;    // state to start from
};

/// Records more of a run than its states.
class Recorder {
 public:
  virtual ~Recorder() = default;

  /// Called after each frame, and before the first one as frame 0.
  virtual void take(const Simulator&, long long frame) = 0;

  /// Called after the last frame, also in a run that was interrupted.
  virtual void finish(const Simulator&) = 0;
};

using MakeRecorder = std::function<std::unique_ptr<Recorder>(const Simulator&)>;

/// Frames nearest to `seconds`, at least one. Throws InvalidValue with the option as key.
long long to_frames(const char* option, double seconds, double frame_duration);

/// The path of a kept frame, as "out/frames/000042" and a suffix.
std::filesystem::path frame_path(const std::filesystem::path& output, long long frame,
                                 const std::string& suffix);

/// Runs a scene, writes the files of `options` and prints the report; messages on standard error
/// begin with `program`. Throws InvalidValue for bad input, std::runtime_error where it cannot
/// write.
ExitCode run(const std::string& program, const RunOptions&, const MakeRecorder& = {});

}  // namespace clothsim
