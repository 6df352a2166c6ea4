// Cost of scenes by the number of their points, in a unit that hardly depends on the machine:
// classic seconds, CPU time over that of the classic configuration on pinned2 at 50 x 50 points,
// with frames of both in turn.

#include <benchmark/benchmark.h>

#include <string>

#include "cpu_time.h"
#include "settled.h"
#include "work_precision/classic.h"

namespace clothsim {
namespace {

/// Cotton that drapes over a flat post.
constexpr const char* post = R"(
cloth: {fabric: cotton_shirting, width: 0.3, height: 0.3, origin: [-0.15, -0.15, 0.302], self_collision: surface}
colliders: [{name: post, shape: cylinder, center: [0, 0, 0.25], axis: [0, 0, 1], length: 0.1, radius: 0.09,
             friction: 0.4}]
simulation: {method: verlet}
)";

/// A scene of this benchmark with `side` x `side` points.
Scene scene_of(const std::string& name, int side) {
  Scene scene;
  if (name == "springs") {  // pinned2 with springs only
    scene = load("pinned2");
    scene.cloth.material.strain_limit.reset();
  } else if (name == "fold_points" || name == "fold_surface") {
    scene = load("self_collision");
    scene.cloth.self_collision =
        name == "fold_points" ? SelfCollision::points : SelfCollision::surface;
  } else if (name == "towel") {  // stands upright on a plane, and falls
    scene = load("self_collision");
    scene.cloth.width = scene.cloth.height = 0.5;
    scene.cloth.material.density = 0.3;
    scene.cloth.material.ks = 1000;
    scene.cloth.thickness = 1e-3;
    scene.cloth.self_collision = SelfCollision::surface;
  } else if (name == "post") {
    scene = read_scene(YAML::Load(post));
  } else {
    scene = load(name);
  }
  scene.cloth.columns = scene.cloth.rows = side;
  for (Pin& pin : scene.cloth.pinned) {  // at corners
    if (pin.column > 0) pin.column = side - 1;
    if (pin.row > 0) pin.row = side - 1;
  }
  return scene;
}

/// Classic seconds per simulated second, in the first `seconds` of a scene.
void cost(benchmark::State& run, const std::string& name) {
  const int side = static_cast<int>(run.range(0)), seconds = static_cast<int>(run.range(1));
  double spent = 0, classic_spent = 0;
  int frames = 0, classic_frames = 0;
  for (auto _ : run) {
    Simulator simulator(scene_of(name, side));
    const Scene yardstick = load("pinned2");
    const auto classic = work_precision::classic(yardstick, 30, 1)();
    const double longest = 1 / yardstick.simulation.frames_per_second;
    const int count = static_cast<int>(seconds / simulator.frame_duration());
    for (int frame = 0; frame < count; ++frame) {
      const double start = process_cpu_seconds();
      simulator.step();
      const double middle = process_cpu_seconds();
      spent += middle - start;
      ++frames;
      if (frame * longest >= 1) continue;  // a second is enough
      classic->step();
      classic_spent += process_cpu_seconds() - middle;
      ++classic_frames;
    }
  }
  const double simulated = frames / 90.0, classic_simulated = classic_frames / 90.0;
  run.counters["classic s"] = spent / simulated / (classic_spent / classic_simulated);
  run.counters["CPU s"] = spent / simulated;
}

void sides(benchmark::internal::Benchmark* b, const std::vector<std::pair<int, int>>& cases) {
  for (const auto& [side, seconds] : cases) b->Args({side, seconds});
  b->ArgNames({"side", "seconds"})->Iterations(1)->Unit(benchmark::kMillisecond);
}

void whole(benchmark::internal::Benchmark* b) { sides(b, {{25, 5}, {50, 5}, {100, 5}, {200, 2}}); }
void begun(benchmark::internal::Benchmark* b) { sides(b, {{25, 5}, {50, 5}, {100, 2}, {200, 2}}); }
void folded(benchmark::internal::Benchmark* b) { sides(b, {{25, 5}, {50, 1}, {50, 5}, {100, 2}}); }

BENCHMARK_CAPTURE(cost, springs, "springs")->Apply(whole);
BENCHMARK_CAPTURE(cost, pinned2, "pinned2")->Apply(whole);
BENCHMARK_CAPTURE(cost, plane, "plane")->Apply(begun);
BENCHMARK_CAPTURE(cost, sphere, "sphere")->Apply(begun);
BENCHMARK_CAPTURE(cost, fold_points, "fold_points")->Apply(folded);
BENCHMARK_CAPTURE(cost, fold_surface, "fold_surface")->Apply(folded);
BENCHMARK_CAPTURE(cost, towel, "towel")->Apply(folded);
BENCHMARK_CAPTURE(cost, post, "post")->Apply(folded);

}  // namespace
}  // namespace clothsim
