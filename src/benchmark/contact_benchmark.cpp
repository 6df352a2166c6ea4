// Cost of self contact on the folded cloth of self_collision, part by part; ratio of a folded
// cloth's simulated time to real time; cost of colliders under a cloth.

#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "clothsim/constraints/collider_contacts.h"
#include "clothsim/constraints/self_contacts.h"
#include "clothsim/dynamics/verlet.h"
#include "clothsim/geometry/intersections.h"
#include "clothsim/search/near_pairs.h"
#include "cpu_time.h"
#include "settled.h"

namespace clothsim {
namespace {

constexpr double folded_after = 3;  // [s] from the start
const Workers one_thread;

Scene pile(SelfCollision kind) {
  Scene scene = load("self_collision");
  scene.cloth.self_collision = kind;
  return scene;
}

const Settled& settled(SelfCollision kind) {
  static const Settled points(pile(SelfCollision::points), folded_after);
  static const Settled surface(pile(SelfCollision::surface), folded_after);
  return kind == SelfCollision::points ? points : surface;
}

/// A substep from the initial folded cloth, so that it stays folded: drift, then the measured
/// contact.
struct Drift {
  explicit Drift(const Settled& from)
      : start(from.simulator.state().positions),
        velocities(from.simulator.state().velocities),
        state(from.simulator.state()),
        h(from.h),
        displacement_factor(
            VelocityVerlet::displacement_factor(from.simulator.cloth().damping, h)) {
    state.velocities.col(2).array() -= 9.8 * h;
    state.positions += h * state.velocities;
  }
  ContactStep step() const { return {h, displacement_factor, start, velocities, one_thread}; }

  Points start;
  Points velocities;
  State state;
  double h;
  double displacement_factor;
};

/// Self contact of a substep: search, four sweeps.
void whole_step(benchmark::State& run, SelfCollision kind) {
  const Settled& scene = settled(kind);
  const Cloth& cloth = scene.simulator.cloth();
  SelfContacts contacts(cloth, kind);
  for (auto _ : run) {
    Drift drift(scene);
    const double start = cpu_seconds();
    contacts.prepare(cloth, drift.step(), drift.state);
    for (int pass = 0; pass < 4; ++pass) contacts.solve_pass(0, drift.state.velocities);
    contacts.guard(cloth, drift.step(), Points(drift.state.positions), drift.state);
    run.SetIterationTime(cpu_seconds() - start);
  }
  run.counters["contacts"] = contacts.count();
  count_points(run, cloth);
}

void points_step(benchmark::State& run) { whole_step(run, SelfCollision::points); }

void surface_step(benchmark::State& run) { whole_step(run, SelfCollision::surface); }

/// The same for the collider that a cloth lies on: `sphere` and `plane` have contacts with points
/// only, `table` and `rod` with faces, too.
void collider_step(benchmark::State& run, const std::string& name) {
  const Scene scene = load(name);
  const Settled lying(scene, 4);
  const Cloth& cloth = lying.simulator.cloth();
  const std::vector<MovingCollider> colliders(scene.colliders.begin(), scene.colliders.end());
  ColliderContacts contacts;
  for (auto _ : run) {
    Drift drift(lying);
    const double start = cpu_seconds();
    contacts.prepare(colliders, cloth, drift.step(), drift.state);
    for (int pass = 0; pass < 4; ++pass) {
      contacts.solve_pass(cloth, drift.state.positions, nullptr, drift.state.velocities);
    }
    contacts.project_positions(colliders, cloth, drift.start, drift.state);
    run.SetIterationTime(cpu_seconds() - start);
  }
  run.counters["contacts"] = contacts.count();
  count_points(run, cloth);
}

/// A search of every pair of patches; in motion, a substep searches a small part of them.
void broad_phase(benchmark::State& run, SelfCollision kind) {
  const Settled& scene = settled(kind);
  const Cloth& cloth = scene.simulator.cloth();
  const Points& x = scene.simulator.state().positions;
  std::size_t pairs = 0;
  for (auto _ : run) {
    NearPairs finder(cloth, stencils_of(kind));
    const double start = cpu_seconds();
    pairs = finder.approaching(x, x).size();
    run.SetIterationTime(cpu_seconds() - start);
  }
  run.counters["pairs"] = static_cast<double>(pairs);
  count_points(run, cloth);
}

void points_broad_phase(benchmark::State& run) { broad_phase(run, SelfCollision::points); }

void surface_broad_phase(benchmark::State& run) { broad_phase(run, SelfCollision::surface); }

/// Distances of near pairs, while points move by 1e-6 m.
void surface_narrow_phase(benchmark::State& run) {
  const Settled& scene = settled(SelfCollision::surface);
  const Cloth& cloth = scene.simulator.cloth();
  const Points x = scene.simulator.state().positions;
  const Points other = (x.array() + 1e-6 * (1e5 * x.array()).sin()).matrix();
  NearPairs finder(cloth);
  bool odd = false;
  std::size_t pairs = 0;
  for (auto _ : run) {
    const Points& now = odd ? other : x;
    const double start = cpu_seconds();
    pairs = finder.approaching(now, now).size();
    run.SetIterationTime(cpu_seconds() - start);
    odd = !odd;
  }
  run.counters["pairs"] = static_cast<double>(pairs);
  count_points(run, cloth);
}

/// A substep after the detection of its contacts.
struct Begun {
  Begun() : contacts(cloth, SelfCollision::surface), drift(settled(SelfCollision::surface)) {
    contacts.prepare(cloth, drift.step(), drift.state);
  }
  const Cloth& cloth = settled(SelfCollision::surface).simulator.cloth();
  SelfContacts contacts;
  Drift drift;
};

/// One pass over the contacts.
void surface_response(benchmark::State& run) {
  Begun step;
  for (auto _ : run) {
    constexpr double none_left_out = -1;
    benchmark::DoNotOptimize(step.contacts.solve_pass(none_left_out, step.drift.state.velocities));
  }
  run.counters["contacts"] = step.contacts.count();
  count_points(run, step.cloth);
}

/// The bound of every point's displacement.
void surface_bounds(benchmark::State& run) {
  Begun step;
  for (auto _ : run) {
    benchmark::DoNotOptimize(step.contacts.guard(
        step.cloth, step.drift.step(), Points(step.drift.state.positions), step.drift.state));
  }
  count_points(run, step.cloth);
}

/// The check for crossings: not part of a substep, run once a second in the node.
void intersection_count(benchmark::State& run) {
  const Settled& scene = settled(SelfCollision::points);
  const Cloth& cloth = scene.simulator.cloth();
  int count = 0;
  for (auto _ : run) {
    count = count_intersections(cloth, scene.simulator.state().positions);
    benchmark::DoNotOptimize(count);
  }
  run.counters["intersecting"] = count;
  count_points(run, cloth);
}

/// Wall time of self_collision with surfaces [s]: `side` x `side` points at `rate` frames a second;
/// the second that folds, the seconds after, and one of the folded cloth.
void surface_real_time(benchmark::State& run) {
  const auto side = static_cast<int>(run.range(0));
  Scene scene = pile(SelfCollision::surface);
  scene.cloth.thickness *= static_cast<double>(scene.cloth.columns - 1) / (side - 1);
  scene.cloth.columns = scene.cloth.rows = side;
  scene.simulation.frames_per_second = static_cast<double>(run.range(1));
  scene.simulation.threads = static_cast<int>(run.range(2));
  for (auto _ : run) {
    Simulator simulator(scene);
    const auto seconds = [&](double duration) {
      const double start = wall_seconds();
      const int frames = static_cast<int>(duration / simulator.frame_duration());
      for (int i = 0; i < frames; ++i) simulator.step();
      return duration / (wall_seconds() - start);
    };
    run.counters["times real time, 1st second"] = seconds(1);
    run.counters["2nd"] = seconds(1);
    run.counters["3rd"] = seconds(1);
    seconds(1);
    run.counters["5th"] = seconds(1);
  }
}

BENCHMARK(points_broad_phase)->UseManualTime();
BENCHMARK(points_step)->UseManualTime();
BENCHMARK(surface_step)->UseManualTime();
BENCHMARK_CAPTURE(collider_step, plane, "plane")->UseManualTime();
BENCHMARK_CAPTURE(collider_step, sphere, "sphere")->UseManualTime();
BENCHMARK_CAPTURE(collider_step, table, "table")->UseManualTime();
BENCHMARK_CAPTURE(collider_step, rod, "rod")->UseManualTime();
BENCHMARK(surface_broad_phase)->UseManualTime();
BENCHMARK(surface_narrow_phase)->UseManualTime();
BENCHMARK(surface_response);
BENCHMARK(surface_bounds);
BENCHMARK(intersection_count);
BENCHMARK(surface_real_time)
    ->ArgNames({"side", "frames/s", "threads"})
    ->Args({50, 60, 1})
    ->Args({50, 60, 2})
    ->Args({100, 20, 1})
    ->Args({100, 20, 2})
    ->Iterations(1)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace clothsim
