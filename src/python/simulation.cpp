#include "simulation.h"

#include <ctime>

#include "clothsim/model/checks.h"

namespace clothsim_python {
namespace {

using clothsim::InvalidValue;

/// CPU time of the calling thread [s].
double thread_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Adds the time from construction to destruction to a run's cost.
class Stopwatch {
 public:
  explicit Stopwatch(clothsim::RunReport& report) : report_(report) {}
  ~Stopwatch() {
    const auto wall = std::chrono::steady_clock::now() - wall_start_;
    report_.wall_seconds += std::chrono::duration<double>(wall).count();
    report_.cpu_seconds += thread_seconds() - cpu_start_;
  }

 private:
  clothsim::RunReport& report_;
  std::chrono::steady_clock::time_point wall_start_ = std::chrono::steady_clock::now();
  double cpu_start_ = thread_seconds();
};

/// Marks the running call, from construction to destruction.
class Watched {
 public:
  Watched(Run& run, SignalWatch& watch) : run_(run) { run.watch = &watch; }
  ~Watched() { run_.watch = nullptr; }

 private:
  Run& run_;
};

}  // namespace

Run::Run(const SceneObject& object)
    : scene(std::make_shared<const SceneObject>(object)),
      simulator(object.scene),
      motions(simulator, object.folder) {
  report.scene = object.file;
  report.overrides = object.overrides;
  report.last_frame.method = object.scene.simulation.method;
  simulator.set_interrupt([this] { return watch != nullptr && watch->asks_to_end(); });
}

void Run::step(int count) {
  const Stopwatch stopwatch(report);
  for (int i = 0; i < count; ++i) {
    motions.play(simulator);
    frames.move(simulator);
    report.add(simulator.step());
  }
}

void Run::reset() {
  simulator.reset();
  frames.reset();
  joints.clear();
  motions = clothsim::MotionPlayer(simulator, scene->folder);
}

const std::map<std::string, clothsim::RobotModel>& Run::robots() {
  if (robots_) return *robots_;
  std::map<std::string, clothsim::RobotModel> robots;
  for (clothsim::RobotModel& model : clothsim::read_robot_models(scene->yaml, {scene->folder})) {
    const bool is_first = robots.count(model.name) == 0;
    const std::string name = is_first ? model.name : model.name + '/' + model.prefix;
    robots.emplace(name, std::move(model));
  }
  robots_ = std::move(robots);
  return *robots_;
}

void Simulation::load(const SceneObject& scene) {
  auto loaded = std::make_shared<Run>(scene);
  const Gate::Visit visit(gate_);
  loaded->simulator.measure_wrenches(run_->simulator.measures_wrenches());
  run_ = std::move(loaded);
}

clothsim::StepReport Simulation::step(int frames, const py::object& targets) {
  check_frames(frames);
  const Targets aims = to_targets(targets, "targets");
  const Gate::Visit visit(gate_);
  Run& run = *run_;
  if (!aims.empty()) {
    clothsim::inside("targets", [&] {
      check_targets(aims, run);
      run.frames.set_targets(aims, frames, run.simulator);
    });
  }
  SignalWatch watch;
  const Watched watched(run, watch);
  try {
    const py::gil_scoped_release release;
    run.step(frames);
  } catch (const clothsim::Interrupted&) {
    watch.raise();
    throw;
  }
  return run.report.last_frame;
}

void check_frames(int frames) {
  if (frames >= 1) return;
  throw InvalidValue({"frames"}, std::to_string(frames), "a whole number of at least 1");
}

void check_targets(const Targets& targets, const Run& run) {
  for (const auto& [frame, target] : targets) {
    clothsim::inside(frame, [&, &t = target] { clothsim::check(t); });
    if (run.frames.pose(frame) != nullptr) continue;
    const std::vector<std::string> known = clothsim::followed_frames(run.simulator);
    if (std::find(known.begin(), known.end(), frame) != known.end()) continue;
    throw InvalidValue({frame}, "a frame that nothing follows",
                       known.empty()
                           ? "one that was placed or attached to"
                           : "one of " + clothsim::join(known) + ", or one that was placed");
  }
}

}  // namespace clothsim_python
