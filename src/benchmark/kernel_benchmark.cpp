// The kernels of a substep against a plain loop over springs, and against the peak rates of the
// machine.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>

#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/verlet.h"
#include "clothsim/model/grid.h"
#include "cpu_time.h"
#include "machine_peak.h"

namespace clothsim {
namespace {

constexpr double h = 1e-5;  // [s]

/// The baseline: one spring at a time, points as rows.
void plain_forces(const Cloth& cloth, const Loads& loads, const Points& x, Points& f) {
  f = cloth.mass * loads.gravity.transpose();
  for_each_spring(cloth, [&](const SpringRun& spring, int a, int b) {
    const Vector3 d = x.row(b) - x.row(a);
    const double length = d.norm();
    const Vector3 pull = spring.stiffness * (length - spring.rest_length) / length * d;
    f.row(a) += pull.transpose();
    f.row(b) -= pull.transpose();
  });
}

/// A grid of run.range(0) points a side with its default material.
struct Setup {
  explicit Setup(const benchmark::State& run) {
    ClothSpec spec;
    spec.columns = spec.rows = static_cast<int>(run.range(0));
    cloth = make_grid(spec);
    state = start_state(spec, cloth, 1);
  }
  Cloth cloth;
  State state;
  Points forces;
};

/// Times `kernel` and the plain loop in turn, so that both run under the same conditions. Prints
/// the ratio of the plain loop to the kernel, and the kernel's shares of the peak rates: square
/// roots and divisions (one each a spring), other arithmetic, and traffic of the second-level
/// cache.
template <typename Kernel>
void against_plain(benchmark::State& run, Setup& setup, double operations, double bytes,
                   Kernel&& kernel) {
  Points f(setup.cloth.num_points(), 3);
  double seconds = 0;
  double plain_seconds = 0;
  for (auto _ : run) {
    // Both with their data in the caches, as in a run of substeps.
    plain_forces(setup.cloth, Loads(), setup.state.positions, f);
    const double start = cpu_seconds();
    for (int i = 0; i < 4; ++i) {
      plain_forces(setup.cloth, Loads(), setup.state.positions, f);
      benchmark::ClobberMemory();
    }
    const double middle = cpu_seconds();
    kernel();
    const double warm = cpu_seconds();
    for (int i = 0; i < 4; ++i) {
      kernel();
      benchmark::ClobberMemory();
    }
    const double end = cpu_seconds();
    plain_seconds += (middle - start) / 4;
    seconds += (end - warm) / 4;
    run.SetIterationTime((end - warm) / 4);
  }
  const double time = seconds / static_cast<double>(run.iterations());
  const double springs = setup.cloth.num_springs();
  const MachinePeak& peak = machine_peak();
  run.counters["plain/this"] = plain_seconds / seconds;
  run.counters["of sqrt+div"] = springs * (1 / peak.square_root + 1 / peak.division) / time;
  run.counters["of mul,add"] = operations / peak.mul_add / time;
  run.counters["of L2 copy"] = bytes / peak.l2_copy / time;
}

// A spring takes 12 operations besides its square root and division, and each side of it 3 more; a
// point's weight 3. A spring's force is written, and read for both of its ends.
double force_operations(const Cloth& cloth) {
  return 18.0 * cloth.num_springs() + 3.0 * cloth.num_points();
}
double force_bytes(const Cloth& cloth) {
  return 8 * (3 * 3.0 * cloth.num_springs() + 7.0 * cloth.num_points());
}

void forces(benchmark::State& run) {
  Setup setup(run);
  against_plain(run, setup, force_operations(setup.cloth), force_bytes(setup.cloth),
                [&] { compute_forces(setup.cloth, Loads(), setup.state.positions, setup.forces); });
}

// Integration reads positions and velocities twice, writes them and the middle of the step, and
// takes 8 operations a coordinate. In single precision springs' forces have half the bytes.
void integration(benchmark::State& run, VelocityVerlet::Parameters::Precision precision) {
  Setup setup(run);
  VelocityVerlet method(VelocityVerlet::Parameters{precision});
  const double numbers = 3.0 * setup.cloth.num_points();
  const bool is_single = precision == VelocityVerlet::Parameters::single_precision;
  const double bytes = force_bytes(setup.cloth) / (is_single ? 2 : 1);
  against_plain(run, setup, force_operations(setup.cloth) + 8 * numbers, bytes + 8 * 7 * numbers,
                [&] { method.step(setup.cloth, Loads(), h, setup.state); });
}

void forces_and_integration(benchmark::State& run) {
  integration(run, VelocityVerlet::Parameters::double_precision);
}

void forces_and_integration_single(benchmark::State& run) {
  integration(run, VelocityVerlet::Parameters::single_precision);
}

/// Wall time of forces and integration with one thread and, in turn, with two: the minimum of each,
/// which is least affected by other work on the machine.
void two_threads(benchmark::State& run) {
  using Clock = std::chrono::steady_clock;
  Setup setup(run);
  VelocityVerlet method;
  const Workers one;
  const Workers two(2);
  const auto seconds_with = [&](const Workers& workers) {
    double least = infinity;
    for (int i = 0; i < 20; ++i) {
      const auto start = Clock::now();
      method.step(setup.cloth, Loads(), h, setup.state, workers);
      least = std::min(least, std::chrono::duration<double>(Clock::now() - start).count());
    }
    return least;
  };
  double alone = infinity;
  double together = alone;
  for (auto _ : run) {
    alone = std::min(alone, seconds_with(one));
    const double seconds = seconds_with(two);
    together = std::min(together, seconds);
    run.SetIterationTime(seconds);
  }
  run.counters["one [us]"] = 1e6 * alone;
  run.counters["two [us]"] = 1e6 * together;
  run.counters["one/two"] = alone / together;
}

BENCHMARK(two_threads)->Arg(50)->Arg(100)->Arg(200)->UseManualTime()->Unit(benchmark::kMicrosecond);
BENCHMARK(forces)->Arg(50)->Arg(200)->UseManualTime()->Unit(benchmark::kMicrosecond);
BENCHMARK(forces_and_integration)
    ->Arg(50)
    ->Arg(200)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(forces_and_integration_single)
    ->Arg(50)
    ->Arg(200)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace clothsim
