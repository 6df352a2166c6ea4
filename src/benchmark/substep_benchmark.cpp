// What a substep costs at 50 x 50, part by part, per point; and each scene as a whole.

#include <benchmark/benchmark.h>

#include <ctime>
#include <string>

#include "clothsim/collision/cell_list.h"
#include "clothsim/collision/intersections.h"
#include "clothsim/collision/point_contacts.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/strain_limit.h"
#include "clothsim/dynamics/verlet.h"
#include "clothsim/model/grid.h"
#include "clothsim/simulation/scene_yaml.h"
#include "clothsim/simulation/simulator.h"

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

/// CPU time of this thread [s]: other work on the machine does not count.
double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// The yardstick: one spring at a time, points as rows.
void plain_forces(benchmark::State& run) {
  const Cloth cloth = make_grid(load("pinned2").cloth);
  const Points& x = cloth.rest_positions;
  const Vector3 gravity(0, 0, -9.8);
  Points f(x.rows(), 3);
  for (auto _ : run) {
    f = cloth.mass * gravity.transpose();
    for_each_spring(cloth, [&](const SpringRun& spring, int a, int b) {
      const Vector3 d = x.row(b) - x.row(a);
      const double length = d.norm();
      const Vector3 pull = spring.stiffness * (length - spring.rest_length) / length * d;
      f.row(a) += pull.transpose();
      f.row(b) -= pull.transpose();
    });
    benchmark::DoNotOptimize(f.data());
    benchmark::ClobberMemory();
  }
  count_points(run, cloth);
}

void forces(benchmark::State& run) {
  const Cloth cloth = make_grid(load("pinned2").cloth);
  Points f(cloth.num_points(), 3);
  for (auto _ : run) {
    compute_forces(cloth, Loads(), cloth.rest_positions, f);
    benchmark::DoNotOptimize(f.data());
    benchmark::ClobberMemory();
  }
  count_points(run, cloth);
}

void forces_and_integration(benchmark::State& run) {
  Scene scene = load("pinned2");
  const Cloth cloth = make_grid(scene.cloth);
  State state = start_state(scene.cloth, cloth, scene.simulation.seed);
  VelocityVerlet method;
  for (auto _ : run) method.step(cloth, Loads(), 1e-5, state);
  count_points(run, cloth);
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
    contacts.begin(cloth, scene.h, reach, scene.simulator.state().velocities, state);
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

BENCHMARK(plain_forces);
BENCHMARK(forces);
BENCHMARK(forces_and_integration);
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
