// What a substep costs at 50 x 50, part by part, per point; and each scene as a whole.

#include <benchmark/benchmark.h>

#include <string>

#include "clothsim/collision/cell_list.h"
#include "clothsim/collision/intersections.h"
#include "clothsim/collision/point_contacts.h"
#include "clothsim/dynamics/strain_limit.h"
#include "clothsim/dynamics/verlet.h"
#include "clothsim/model/grid.h"
#include "clothsim/simulation/scene_yaml.h"
#include "clothsim/simulation/simulator.h"
#include "cpu_time.h"
#include "work_precision/classic.h"

namespace clothsim {
namespace {

const std::string scenes = CLOTHSIM_SCENES_DIR;

Scene load(const std::string& name) {
  return read_scene(load_scene_file(scenes + "/" + name + ".yaml"));
}

/// A scene after `seconds`, with the step its substeps had.
struct Settled {
  Settled(const std::string& name, double seconds) : simulator(load(name)) {
    const int frames = static_cast<int>(seconds / simulator.frame_duration());
    for (int i = 0; i < frames; ++i) report = simulator.step();
    h = simulator.frame_duration() / report.substeps;
  }

  Simulator simulator;
  StepReport report;
  double h = 0;
};

void count_points(benchmark::State& run, const Cloth& cloth) {
  run.counters["per point"] = benchmark::Counter(
      static_cast<double>(cloth.num_points()) * static_cast<double>(run.iterations()),
      benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

/// Everything but forces and integration in a substep of pinned2, hanging at rest.
void strain_limit(benchmark::State& run) {
  const Settled scene("pinned2", 4);
  const Cloth& cloth = scene.simulator.cloth();
  State state = scene.simulator.state();
  StrainLimit limit(cloth);
  VelocityVerlet method;
  const double reach = VelocityVerlet::reach(cloth.damping, scene.h);
  Points predicted;
  for (auto _ : run) {
    method.step(cloth, Loads(), scene.h, state);
    const double start = cpu_seconds();
    limit.predict(cloth, scene.h, reach, state);
    predicted = state.velocities;
    limit.begin(cloth, reach, state);
    for (int sweep = 0; sweep < 4; ++sweep) limit.sweep(cloth, state.velocities);
    state.positions += reach * scene.h * (state.velocities - predicted);
    limit.correct(cloth, 0.004, 200, state.positions);
    run.SetIterationTime(cpu_seconds() - start);
  }
  count_points(run, cloth);
}

/// All pairs of the folded cloth within the contact distance and its skin.
void pair_search_folded(benchmark::State& run) {
  const Settled scene("self_collision", 3);
  const Cloth& cloth = scene.simulator.cloth();
  PairFinder finder;
  std::vector<PointPair> pairs;
  for (auto _ : run) {
    finder.find(scene.simulator.state().positions, 3 * cloth.thickness, pairs);
    benchmark::DoNotOptimize(pairs.data());
  }
  run.counters["pairs"] = static_cast<double>(pairs.size());
  count_points(run, cloth);
}

/// Self contact of a substep on the folded cloth: candidates when they are due, four sweeps.
void self_collision_folded(benchmark::State& run) {
  const Settled scene("self_collision", 3);
  const Cloth& cloth = scene.simulator.cloth();
  const double reach = VelocityVerlet::reach(cloth.damping, scene.h);
  PointContacts contacts;
  State state;
  for (auto _ : run) {
    // Each substep drifts from the pile as it was, so that it stays folded.
    state = scene.simulator.state();
    state.velocities.array() -= 9.8 * scene.h;
    state.positions += scene.h * state.velocities;
    const double start = cpu_seconds();
    contacts.begin(cloth, {scene.h, reach, state.positions, scene.simulator.state().velocities},
                   state);
    for (int sweep = 0; sweep < 4; ++sweep) contacts.sweep(cloth, state.velocities);
    contacts.correct(cloth, state.positions);
    run.SetIterationTime(cpu_seconds() - start);
  }
  run.counters["contacts"] = contacts.count();
  count_points(run, cloth);
}

/// The judge: no part of a substep, run once a second in the node.
void intersection_count_folded(benchmark::State& run) {
  const Settled scene("self_collision", 3);
  const Cloth& cloth = scene.simulator.cloth();
  int count = 0;
  for (auto _ : run) {
    count = count_intersections(cloth, scene.simulator.state().positions);
    benchmark::DoNotOptimize(count);
  }
  run.counters["intersecting"] = count;
  count_points(run, cloth);
}

/// Five simulated seconds of a scene from its start: CPU time, and how many times real time.
void scene(benchmark::State& run, const std::string& name) {
  constexpr double seconds = 5;
  for (auto _ : run) Settled(name, seconds);
  run.counters["times real time"] = benchmark::Counter(
      seconds * static_cast<double>(run.iterations()), benchmark::Counter::kIsRate);
}

/// The headline: pinned2 at its defaults against the classic way, plain loops with 30 substeps a
/// frame and one pass of the strain limit a substep; frame by frame in turn, for 5 s.
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

BENCHMARK(pinned2_against_classic)->Unit(benchmark::kMillisecond);
BENCHMARK(strain_limit)->UseManualTime();
BENCHMARK(pair_search_folded);
BENCHMARK(self_collision_folded)->UseManualTime();
BENCHMARK(intersection_count_folded);
BENCHMARK_CAPTURE(scene, pinned2, "pinned2")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(scene, pinned4, "pinned4")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(scene, sphere, "sphere")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(scene, plane, "plane")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(scene, self_collision, "self_collision")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace clothsim

BENCHMARK_MAIN();
