#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/simulation/simulator.h"

namespace clothsim {

/// Of the programs that run a scene.
enum ExitCode { done = 0, bad_input = 1, diverged = 2, interrupted = 130 };

struct RunOptions {
  std::string scene;
  std::optional<double> seconds;  // none: those of the motions
  std::optional<double> every;  // [s] from one frame that is kept to the next; none: only the last
  std::vector<std::string> overrides;
  std::filesystem::path output;  // folder; empty: no files
  std::filesystem::path from;    // state to start from
};

/// Keeps more of a run than its states.
class Recorder {
 public:
  virtual ~Recorder() = default;

  /// After each frame, and before the first as frame 0.
  virtual void take(const Simulator&, long long frame) = 0;

  /// After the last frame, also of a run that was broken off.
  virtual void finish(const Simulator&) = 0;
};

using MakeRecorder = std::function<std::unique_ptr<Recorder>(const Simulator&)>;

/// Frames nearest to `seconds`, at least one. Throws InvalidValue with the option as key.
long long to_frames(const char* option, double seconds, double frame_duration);

/// Where a kept frame is written, as "out/frames/000042" and a suffix.
std::filesystem::path frame_path(const std::filesystem::path& output, long long frame,
                                 const std::string& suffix);

/// Runs a scene, writes what is asked for and prints the report; `program` begins what it says on
/// standard error. Throws InvalidValue for bad input, std::runtime_error where it cannot write.
ExitCode run(const std::string& program, const RunOptions&, const MakeRecorder& = {});

}  // namespace clothsim
