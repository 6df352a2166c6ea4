// The time of a simulated second with one thread and with two.

#include <algorithm>
#include <memory>

#include "../cpu_time.h"
#include "chart.h"
#include "clothsim/simulation/simulator.h"
#include "scenes.h"
#include "table.h"

namespace clothsim::work_precision {
namespace {

struct ThreadSeries {
  const char* name;
  Scene (*scene)(int side);
  std::vector<int> sides;  // points along either side
  int frames;
  int measured_from;  // first frame whose time counts
};

Scene limited_drop(int side) { return shipped_scene("pinned2", side); }

std::vector<ThreadSeries> thread_series(bool quick) {
  if (quick) return {{"springs", corner_drop, {10}, 2, 0}};
  return {{"springs", corner_drop, {25, 50, 100, 200}, 45, 0},
          {"strain limit", limited_drop, {25, 50, 100, 200}, 45, 0},
          {"folds", fold, {25, 50, 100}, 54, 36}};  // as its first folds touch
}

/// Per simulated second [s]; the minimum of several runs, which is least affected by other work.
struct Time {
  double wall = infinity;
  double cpu = infinity;

  void measure(const ThreadSeries& s, const Scene& scene) {
    Simulator simulator(scene);
    for (int frame = 0; frame < s.measured_from; ++frame) simulator.step();
    const double wall_start = wall_seconds();
    const double cpu_start = process_cpu_seconds();
    for (int frame = s.measured_from; frame < s.frames; ++frame) simulator.step();
    const double simulated = (s.frames - s.measured_from) * simulator.frame_duration();
    wall = std::min(wall, (wall_seconds() - wall_start) / simulated);
    cpu = std::min(cpu, (process_cpu_seconds() - cpu_start) / simulated);
  }
};

}  // namespace

std::vector<Job> threads_jobs(const Options& options) {
  auto table = std::make_shared<Table>(
      std::vector<std::string>{"scene", "side", "threads", "wall_ms_per_s", "cpu_ms_per_s"});
  std::vector<Job> jobs;
  for (const ThreadSeries& s : thread_series(options.quick)) {
    for (const int side : s.sides) {
      jobs.push_back([=] {
        Time times[2];
        constexpr int rounds = 3;
        for (int round = 0; round < rounds; ++round) {  // in turn: under the same conditions
          for (const int threads : {1, 2}) {
            Scene scene = s.scene(side);
            scene.simulation.threads = threads;
            times[threads - 1].measure(s, scene);
          }
        }
        for (const int threads : {1, 2}) {
          const Time& time = times[threads - 1];
          table->add({s.name, side, threads, 1e3 * time.wall, 1e3 * time.cpu});
        }
      });
    }
  }
  jobs.push_back([=] { table->write(options.output / "threads.csv"); });
  return jobs;
}

}  // namespace clothsim::work_precision
