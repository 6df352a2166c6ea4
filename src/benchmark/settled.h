#pragma once

#include <benchmark/benchmark.h>

#include <string>

#include "clothsim/scene/scene_yaml.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim {

/// A shipped scene.
inline Scene load(const std::string& name) {
  return read_scene(load_scene_file(CLOTHSIM_SCENES_DIR + ("/" + name + ".yaml")));
}

/// A scene after `seconds`, with the step of its substeps.
struct Settled {
  Settled(const Scene& scene, double seconds) : simulator(scene) {
    const int frames = static_cast<int>(seconds / simulator.frame_duration());
    for (int i = 0; i < frames; ++i) report = simulator.step();
    h = simulator.frame_duration() / report.substeps;
  }

  Simulator simulator;
  StepReport report;
  double h = 0;
};

/// Time per point.
inline void count_points(benchmark::State& run, const Cloth& cloth) {
  run.counters["per point"] = benchmark::Counter(
      static_cast<double>(cloth.num_points()) * static_cast<double>(run.iterations()),
      benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

}  // namespace clothsim
