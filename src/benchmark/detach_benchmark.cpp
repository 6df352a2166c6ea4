// Cost of detaching points: per point that a call names, for any number of attached points.

#include <benchmark/benchmark.h>

#include <numeric>
#include <vector>

#include "clothsim/simulation/simulator.h"

namespace clothsim {
namespace {

/// A call that names all points of a cloth of run.range(0) a side, each run.range(1) times.
void detach(benchmark::State& run) {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = static_cast<int>(run.range(0));
  Simulator simulator(scene);
  std::vector<int> all(static_cast<std::size_t>(simulator.cloth().num_points()));
  std::iota(all.begin(), all.end(), 0);
  std::vector<int> named;
  for (int i = 0; i < run.range(1); ++i) named.insert(named.end(), all.begin(), all.end());
  for (auto _ : run) {
    run.PauseTiming();
    simulator.attach("hand", Pose(), all);
    run.ResumeTiming();
    simulator.detach(named);
  }
  run.counters["a point"] = benchmark::Counter(
      static_cast<double>(named.size()),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

BENCHMARK(detach)->Args({50, 1})->Args({100, 1})->Args({100, 100})->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace clothsim
