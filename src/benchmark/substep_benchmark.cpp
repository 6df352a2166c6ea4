// Cost of a substep at 50 x 50, part by part, per point; and of each scene as a whole.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <string>
#include <vector>

#include "clothsim/constraints/strain_limit.h"
#include "clothsim/dynamics/verlet.h"
#include "cpu_time.h"
#include "settled.h"
#include "work_precision/classic.h"

namespace clothsim {
namespace {

/// Everything but forces and integration in a substep of pinned2, hanging at rest.
void strain_limit(benchmark::State& run) {
  const Settled scene(load("pinned2"), 4);
  const Cloth& cloth = scene.simulator.cloth();
  State state = scene.simulator.state();
  StrainLimit limit(cloth);
  VelocityVerlet method;
  const double displacement_factor = VelocityVerlet::displacement_factor(cloth.damping, scene.h);
  Points predicted;
  for (auto _ : run) {
    method.step(cloth, Loads(), scene.h, state);
    const double start = cpu_seconds();
    limit.warm_start(scene.h, displacement_factor, state);
    predicted = state.velocities;
    limit.prepare(cloth, displacement_factor, state);
    for (int pass = 0; pass < 4; ++pass) limit.solve_pass(state.velocities);
    state.positions += displacement_factor * scene.h * (state.velocities - predicted);
    limit.project_positions(cloth, 0.004, 200, state.positions);
    run.SetIterationTime(cpu_seconds() - start);
  }
  count_points(run, cloth);
}

/// Five simulated seconds of a scene from its start: CPU time, and how many times real time.
void scene(benchmark::State& run, const std::string& name) {
  constexpr double seconds = 5;
  for (auto _ : run) Settled(load(name), seconds);
  run.counters["times real time"] = benchmark::Counter(
      seconds * static_cast<double>(run.iterations()), benchmark::Counter::kIsRate);
}

/// The headline figure: pinned2 at its defaults against the classic method, plain loops with 30
/// substeps a frame and one pass of the strain limit a substep; frame by frame in turn, for 5 s.
void pinned2_against_classic(benchmark::State& run) {
  const Scene scene = load("pinned2");
  double seconds = 0;
  double classic_seconds = 0;
  for (auto _ : run) {
    Simulator simulator(scene);
    const auto classic = work_precision::classic(scene, 30, 1)();
    for (int frame = 0; frame < 450; ++frame) {
      const double start = cpu_seconds();
      simulator.step();
      const double middle = cpu_seconds();
      classic->step();
      const double end = cpu_seconds();
      seconds += middle - start;
      classic_seconds += end - middle;
    }
  }
  const double simulated = 5 * static_cast<double>(run.iterations());
  run.counters["CPU s per s"] = seconds / simulated;
  run.counters["classic CPU s per s"] = classic_seconds / simulated;
  run.counters["classic/this"] = classic_seconds / seconds;
}

/// Wall time of a frame of pinned2, with strain limit, with one thread and, in turn, with two, from
/// its start. The median of the ratios of all frames, as other work on the machine affects some.
void pinned2_with_two_threads(benchmark::State& run) {
  Scene scene = load("pinned2");
  scene.cloth.columns = scene.cloth.rows = static_cast<int>(run.range(0));
  scene.cloth.pinned = {{0, 0, ""}, {scene.cloth.columns - 1, 0, ""}};
  std::vector<double> ratios;
  const auto seconds_of = [](Simulator& simulator) {
    const double start = wall_seconds();
    simulator.step();
    return wall_seconds() - start;
  };
  for (auto _ : run) {
    scene.simulation.threads = 1;
    Simulator one(scene);
    scene.simulation.threads = 2;
    Simulator two(scene);
    for (int frame = 0; frame < 30; ++frame) {
      const double alone = seconds_of(one);
      ratios.push_back(alone / seconds_of(two));
    }
    if (one.state().positions != two.state().positions) run.SkipWithError("not the same bits");
  }
  std::sort(ratios.begin(), ratios.end());
  run.counters["one/two"] = ratios[ratios.size() / 2];
}

BENCHMARK(pinned2_with_two_threads)
    ->Arg(50)
    ->Arg(200)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(pinned2_against_classic)->Unit(benchmark::kMillisecond);
BENCHMARK(strain_limit)->UseManualTime();
BENCHMARK_CAPTURE(scene, pinned2, "pinned2")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(scene, pinned4, "pinned4")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(scene, sphere, "sphere")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(scene, plane, "plane")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(scene, self_collision, "self_collision")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace clothsim

BENCHMARK_MAIN();
