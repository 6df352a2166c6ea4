#include "run.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <regex>
#include <set>

#include "clothsim/model/checks.h"
#include "clothsim/model/files.h"
#include "clothsim/run/motion_player.h"
#include "clothsim/run/output.h"
#include "clothsim/run/progress_bar.h"
#include "clothsim/run/report.h"
#include "clothsim/scene/doubts.h"
#include "clothsim/scene/scene_yaml.h"

namespace clothsim {
namespace {

namespace fs = std::filesystem;

/// Creates the folder, without frames of an earlier run; other files remain.
void make_free_of_frames(const fs::path& directory) {
  fs::create_directories(directory);
  const std::regex frame("\\d{6,}(\\.ply|_(color|depth|mask)\\.png)");
  std::vector<fs::path> old;
  for (const auto& entry : fs::directory_iterator(directory)) {
    if (entry.is_regular_file() && std::regex_match(entry.path().filename().string(), frame))
      old.push_back(entry.path());
  }
  for (const fs::path& path : old) fs::remove(path);
}

volatile std::sig_atomic_t is_interrupted = 0;

void interrupt(int) { is_interrupted = 1; }

/// Places the colliders as in the state, if it has the same number of them.
void place_colliders(const std::string& program, const std::vector<Pose>& poses,
                     Simulator& simulator) {
  const std::size_t count = simulator.scene().colliders.size();
  if (poses.size() != count) {
    if (!poses.empty()) {
      std::cerr << program << ": the state has " << poses.size() << " colliders, the scene "
                << count << ": they start where the scene has them\n";
    }
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    inside("colliders", [&] {
      inside(std::to_string(i), [&] { simulator.place_collider(static_cast<int>(i), poses[i]); });
    });
  }
}

/// Starts from a saved state, with the same bits where its memory fits this cloth and method.
void start_from(const std::string& program, const fs::path& path, Simulator& simulator) {
  const StateFile file = read_state(path);
  inside(path.string(), [&] {
    const ClothSpec& cloth = simulator.scene().cloth;
    if (file.state.positions.rows() == simulator.cloth().num_points()) {
      for (std::size_t i = 0; i < cloth.pinned.size(); ++i) {
        const int point = cloth.pinned[i].row * cloth.columns + cloth.pinned[i].column;
        simulator.place_pin(static_cast<int>(i), file.state.positions.row(point).transpose());
      }
    }
    place_colliders(program, file.colliders, simulator);
    try {
      simulator.set_state(file.state, file.memory);
    } catch (const InvalidValue& error) {
      if (file.memory.empty() || error.key()[0] != "memory") throw;
      std::cerr << program << ": " << path.string()
                << " is of another cloth or method: it goes on without a memory\n";
      simulator.set_state(file.state);
    }
  });
}

/// Prints how many colliders and pins follow a frame that no motion moves.
void tell_of_frames(const std::string& program, const Scene& scene) {
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
  std::cerr << program
            << ": without ROS no tf frame moves: what follows one stays still (colliders: "
            << colliders << ", pins: " << pins << ")\n";
}

/// Adds the time from construction to destruction to a run's cost.
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

/// Files of a run, other than pictures.
class Files {
 public:
  /// Makes the folders first, so that a long run cannot fail for lack of them.
  Files(const RunOptions& options, const Simulator& simulator) : output_(options.output) {
    if (output_.empty()) return;
    if (options.every) every_ = to_frames("--every", *options.every, simulator.frame_duration());
    fs::create_directories(output_);
    if (every_ == 0) return;
    make_free_of_frames(output_ / "frames");
    frames_.emplace(output_ / "frames.npz", simulator.cloth());
  }

  void take(const Simulator& simulator, long long frame) {
    if (!frames_ || frame % every_ != 0) return;
    frames_->append(simulator.state());
    write_file(frame_path(output_, frame, ".ply"),
               to_ply(simulator.cloth(), simulator.state().positions));
  }

  void finish(const Simulator& simulator, const std::string& report) {
    if (output_.empty()) return;
    write_file(output_ / "final.csv", to_csv(simulator.state()));
    write_state(output_ / "final.npz", state_file(simulator));
    if (frames_) frames_->finish();
    write_file(output_ / "report.yaml", report);
  }

 private:
  fs::path output_;
  long long every_ = 0;
  std::optional<FramesFile> frames_;
};

/// Steps until the end, an interrupt or an invalid state; `keep` gets each frame.
RunReport play(const std::string& program, long long frames, MotionPlayer& player,
               Simulator& simulator, const std::function<void(long long)>& keep) {
  RunReport run;
  run.last_frame.method = simulator.scene().simulation.method;
  keep(0);
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
        std::cerr << program << ": frame " << run.frames << " was taken back "
                  << run.last_frame.recoveries << " times: now " << run.last_frame.method << ", "
                  << run.last_frame.substeps << " substeps\n";
      }
      keep(run.frames);
    }
  } catch (const Interrupted& error) {
    std::cerr << program << ": " << error.what() << ": the results are of " << run.frames
              << " frames\n";
  } catch (const Diverged& error) {
    run.error = error.what();
    std::cerr << program << ": diverged in frame " << run.frames + 1 << ": " << error.what()
              << '\n';
  }
  return run;
}

}  // namespace

long long to_frames(const char* option, double seconds, double frame_duration) {
  constexpr Range range{1e-6, 1e9, "s"};
  check_range(option, seconds, range);
  return std::max(1LL, std::llround(seconds / frame_duration));
}

fs::path frame_path(const fs::path& output, long long frame, const std::string& suffix) {
  std::array<char, 32> name;
  std::snprintf(name.data(), name.size(), "%06lld", frame);
  return output / "frames" / (name.data() + suffix);
}

ExitCode run(const std::string& program, const RunOptions& options,
             const MakeRecorder& make_recorder) {
  YAML::Node yaml = load_scene_file(options.scene);
  override_values(yaml, options.overrides);
  const fs::path folder = fs::path(options.scene).parent_path();
  Simulator simulator(read_scene(yaml, {folder}));

  MotionPlayer player(simulator, folder);
  if (!options.from.empty()) start_from(program, options.from, simulator);
  if (const int pairs = simulator.given_crossings(); pairs > 0) {
    std::cerr << program << ": the state crosses itself in " << pairs
              << " pairs of triangles, which stay crossed"
              << (simulator.scene().cloth.untangle ? ": cloth.untangle could not take them apart\n"
                                                   : ": cloth.untangle=true takes them apart\n");
  }
  if (!options.seconds && simulator.scene().motions.empty())
    throw InvalidValue({"--seconds"}, "nothing", "a time [s], as the scene has no motions");
  const long long frames = to_frames("--seconds", options.seconds.value_or(player.duration()),
                                     simulator.frame_duration());

  tell_of_frames(program, simulator.scene());
  for (const std::string& line : simulator.scene().left_out) {
    std::cerr << program << ": left out " << line << '\n';
  }
  for (const std::string& line : doubts(yaml, simulator.scene())) {
    std::cerr << program << ": " << line << '\n';
  }
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, interrupt);
  simulator.set_interrupt([] { return is_interrupted != 0; });

  Files files(options, simulator);
  const std::unique_ptr<Recorder> recorder = make_recorder ? make_recorder(simulator) : nullptr;
  RunReport report = play(program, frames, player, simulator, [&](long long frame) {
    files.take(simulator, frame);
    if (recorder) recorder->take(simulator, frame);
  });
  report.scene = options.scene;
  report.overrides = options.overrides;
  const std::string text = to_yaml(report, simulator);
  files.finish(simulator, text);
  if (recorder) recorder->finish(simulator);
  if (!(std::cout << text << std::flush)) throw std::runtime_error("cannot write the report");
  if (is_interrupted) return interrupted;
  return report.error.empty() ? done : diverged;
}

}  // namespace clothsim
