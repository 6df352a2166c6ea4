#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <optional>
#include <set>
#include <vector>

#include "clothsim/model/checks.h"
#include "clothsim/model/files.h"
#include "clothsim/simulation/motion_player.h"
#include "clothsim/simulation/output.h"
#include "clothsim/simulation/progress_bar.h"
#include "clothsim/simulation/report.h"
#include "clothsim/simulation/scene_yaml.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim {
namespace {

enum ExitCode { done = 0, bad_input = 1, diverged = 2, interrupted = 130 };

struct Options {
  std::string scene;
  std::optional<double> seconds;
  std::vector<std::string> overrides;
  std::optional<double> every;  // [s]
  std::filesystem::path output;
  std::filesystem::path from;  // state to start from
};

/// Frames nearest to `seconds`, at least one.
long long to_frames(const char* option, double seconds, double frame_duration) {
  constexpr Range range{1e-6, 1e9, "s"};
  check_range(option, seconds, range);
  return std::max(1LL, std::llround(seconds / frame_duration));
}

std::filesystem::path frame_path(const std::filesystem::path& directory, long long frame) {
  std::array<char, 32> name;
  std::snprintf(name.data(), name.size(), "%06lld.ply", frame);
  return directory / name.data();
}

/// A folder without frames of an earlier run; other files stay.
void make_free_of_frames(const std::filesystem::path& directory) {
  std::filesystem::create_directories(directory);
  std::vector<std::filesystem::path> old;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    const std::string name = entry.path().stem().string();
    const bool is_number = name.size() >= 6 && name.find_first_not_of("0123456789") == name.npos;
    if (entry.is_regular_file() && is_number && entry.path().extension() == ".ply") {
      old.push_back(entry.path());
    }
  }
  for (const std::filesystem::path& path : old) std::filesystem::remove(path);
}

volatile std::sig_atomic_t is_interrupted = 0;

void interrupt(int) { is_interrupted = 1; }

/// Puts colliders where the state has them, if it is of as many.
void place_colliders(const std::vector<Pose>& poses, Simulator& simulator) {
  const std::size_t count = simulator.scene().colliders.size();
  if (poses.size() != count) {
    if (!poses.empty()) {
      std::cerr << "simulate: the state has " << poses.size() << " colliders, the scene " << count
                << ": they start where the scene has them\n";
    }
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    inside("colliders", [&] {
      inside(std::to_string(i), [&] { simulator.place_collider(static_cast<int>(i), poses[i]); });
    });
  }
}

/// Starts from a saved state, to the same bits where its memory is of this cloth and method.
void start_from(const std::filesystem::path& path, Simulator& simulator) {
  const StateFile file = read_state(path);
  inside(path.string(), [&] {
    const ClothSpec& cloth = simulator.scene().cloth;
    if (file.state.positions.rows() == simulator.cloth().num_points()) {
      for (std::size_t i = 0; i < cloth.pinned.size(); ++i) {
        const int point = cloth.pinned[i].row * cloth.columns + cloth.pinned[i].column;
        simulator.place_pin(static_cast<int>(i), file.state.positions.row(point).transpose());
      }
    }
    place_colliders(file.colliders, simulator);
    try {
      simulator.set_state(file.state, file.memory);
    } catch (const InvalidValue& error) {
      if (file.memory.empty() || error.key()[0] != "memory") throw;
      std::cerr << "simulate: " << path.string()
                << " is of another cloth or method: it goes on without a memory\n";
      simulator.set_state(file.state);
    }
  });
}

/// Says what stays still although the scene has it follow a frame, which no motion moves.
void tell_of_frames(const Scene& scene) {
  std::set<std::string> moved;
  for (const MotionEntry& entry : scene.motions) {
    if (const auto* key = std::get_if<KeyFrame>(&entry.action)) moved.insert(key->frame);
    if (const auto* file = std::get_if<KeyFrameFile>(&entry.action)) moved.insert(file->frame);
  }
  const auto follows = [&](const auto& item) {
    return !item.frame.empty() && moved.count(item.frame) == 0;
  };
  const auto count = [&](const auto& items) {
    return std::count_if(items.begin(), items.end(), follows);
  };
  const auto colliders = count(scene.colliders), pins = count(scene.cloth.pinned);
  if (colliders + pins == 0) return;
  std::cerr << "simulate: without ROS no tf frame moves: what follows one stays still (colliders: "
            << colliders << ", pins: " << pins << ")\n";
}

/// Adds to a run's cost from construction to destruction.
class Stopwatch {
 public:
  explicit Stopwatch(RunReport& run) : run_(run) {}
  ~Stopwatch() {
    const auto wall = std::chrono::steady_clock::now() - wall_start_;
    run_.wall_seconds += std::chrono::duration<double>(wall).count();
    run_.cpu_seconds += static_cast<double>(std::clock() - cpu_start_) / CLOCKS_PER_SEC;
  }

 private:
  RunReport& run_;
  std::chrono::steady_clock::time_point wall_start_ = std::chrono::steady_clock::now();
  std::clock_t cpu_start_ = std::clock();
};

ExitCode simulate(const Options& options) {
  YAML::Node yaml = load_scene_file(options.scene);
  override_values(yaml, options.overrides);
  const std::filesystem::path folder = std::filesystem::path(options.scene).parent_path();
  Simulator simulator(read_scene(yaml, {folder}));

  MotionPlayer player(simulator, folder);
  if (!options.from.empty()) start_from(options.from, simulator);
  if (!options.seconds && simulator.scene().motions.empty())
    throw InvalidValue({"--seconds"}, "nothing", "a time [s], as the scene has no motions");

  const double frame_duration = simulator.frame_duration();
  const long long frames =
      to_frames("--seconds", options.seconds.value_or(player.duration()), frame_duration);
  const long long every = options.every ? to_frames("--every", *options.every, frame_duration) : 0;

  tell_of_frames(simulator.scene());
  for (const std::string& line : simulator.scene().left_out) {
    std::cerr << "simulate: left out " << line << '\n';
  }
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, interrupt);
  simulator.set_interrupt([] { return is_interrupted != 0; });

  // Make the folders first: a run should not end in vain.
  const std::filesystem::path frame_directory = options.output / "frames";
  if (!options.output.empty()) std::filesystem::create_directories(options.output);
  if (every > 0) make_free_of_frames(frame_directory);
  std::optional<FramesFile> frames_file;
  if (every > 0) frames_file.emplace(options.output / "frames.npz", simulator.cloth());
  const auto write_frame = [&](long long frame) {
    if (every == 0 || frame % every != 0) return;
    frames_file->append(simulator.state());
    write_file(frame_path(frame_directory, frame),
               to_ply(simulator.cloth(), simulator.state().positions));
  };

  RunReport run;
  run.scene = options.scene;
  run.overrides = options.overrides;
  run.last_frame.method = simulator.scene().simulation.method;
  write_frame(0);
  try {
    ProgressBar bar(frames);
    while (run.frames < frames) {
      bar.update(run.frames);
      {
        const Stopwatch stopwatch(run);
        player.play(simulator);
        run.add(simulator.step());
      }
      if (run.last_frame.recoveries > 0) {
        std::cerr << "simulate: frame " << run.frames << " was taken back "
                  << run.last_frame.recoveries << " times: now " << run.last_frame.method << ", "
                  << run.last_frame.substeps << " substeps\n";
      }
      write_frame(run.frames);
    }
  } catch (const Interrupted& error) {
    std::cerr << "simulate: " << error.what() << ": the results are of " << run.frames
              << " frames\n";
  } catch (const Diverged& error) {
    run.error = error.what();
    std::cerr << "simulate: diverged in frame " << run.frames + 1 << ": " << error.what() << '\n';
  }

  const std::string report = to_yaml(run, simulator);
  if (!options.output.empty()) {
    write_file(options.output / "final.csv", to_csv(simulator.state()));
    write_state(options.output / "final.npz", state_file(simulator));
    if (frames_file) frames_file->finish();
    write_file(options.output / "report.yaml", report);
  }
  if (!(std::cout << report << std::flush)) throw std::runtime_error("cannot write the report");
  if (is_interrupted) return interrupted;
  return run.error.empty() ? done : diverged;
}

}  // namespace
}  // namespace clothsim

int main(int argc, char** argv) {
  clothsim::Options options;
  CLI::App app("Runs a cloth scene as fast as it goes, without ROS, and prints a report.");
  app.add_option("scene", options.scene, "Scene file (YAML)")->required();
  app.add_option("--seconds", options.seconds,
                 "Time to simulate [s], rounded to whole frames; without it that of the motions");
  app.add_option(
      "--from", options.from,
      "Start from the state in a final.npz, or of the last frame in a frames.npz; motions "
      "begin then");
  app.add_option("--set", options.overrides, "Change a value of the scene: --set cloth.ks=500")
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE");
  CLI::Option* output =
      app.add_option("--output", options.output,
                     "Folder for final.csv, final.npz, report.yaml, frames.npz and frames/");
  app.add_option("--every", options.every,
                 "Also write frames.npz, and frames/NNNNNN.ply, one each so much time [s], rounded "
                 "to whole frames; "
                 "those of an earlier run are removed")
      ->needs(output);
  app.footer(
      "Exit status: 0 done, 1 bad input, 2 diverged, 130 interrupted (files hold the last "
      "good frame). Pictures and a video of a run: film, with the same scene, --set, --seconds and "
      "--every.");

  try {
    app.parse(argc, argv);
    return clothsim::simulate(options);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? clothsim::done : clothsim::bad_input;
  } catch (const std::exception& error) {
    std::cerr << "simulate: " << error.what() << '\n';
    return clothsim::bad_input;
  }
}
