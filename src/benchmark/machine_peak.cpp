#include "machine_peak.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "clothsim/model/target_clones.h"
#include "cpu_time.h"

namespace clothsim {
namespace {

constexpr int l1_numbers = 2'048;   // 16 KiB
constexpr int l2_numbers = 24'576;  // 192 KiB
constexpr int chains = 64;          // independent sums: enough to hide latencies

/// Sums `n` numbers, a multiple of `chains`, into `sums`.
CLOTHSIM_TARGET_CLONES
void read_all(const double* __restrict x, int n, double* __restrict sums) {
  double s[chains] = {};
  for (int i = 0; i < n; i += chains) {
    for (int k = 0; k < chains; ++k) s[k] += x[i + k];
  }
  for (int k = 0; k < chains; ++k) sums[k] = s[k];
}

CLOTHSIM_TARGET_CLONES
void copy(const double* __restrict from, int n, double* __restrict to) {
  for (int i = 0; i < n; ++i) to[i] = 1.5 * from[i];
}

/// `n` times y = y a + b on each chain.
CLOTHSIM_TARGET_CLONES
void multiply_and_add(double a, double b, int n, double* __restrict y) {
  double s[chains];
  for (int k = 0; k < chains; ++k) s[k] = y[k];
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < chains; ++k) s[k] = s[k] * a + b;
  }
  for (int k = 0; k < chains; ++k) y[k] = s[k];
}

CLOTHSIM_TARGET_CLONES
void square_roots(const double* __restrict x, int n, double* __restrict y) {
  for (int i = 0; i < n; ++i) y[i] = std::sqrt(x[i]);
}

CLOTHSIM_TARGET_CLONES
void divisions(const double* __restrict x, int n, double* __restrict y) {
  for (int i = 0; i < n; ++i) y[i] = 1.5 / x[i];
}

/// Highest rate of `work`, which does `amount`, per second.
template <typename Work>
double rate(double amount, Work&& work) {
  double best = 0;
  for (int trial = 0; trial < 10; ++trial) {
    constexpr int repeats = 100;
    const double start = cpu_seconds();
    for (int i = 0; i < repeats; ++i) {
      work();
      benchmark::ClobberMemory();
    }
    best = std::max(best, repeats * amount / (cpu_seconds() - start));
  }
  return best;
}

MachinePeak measure() {
  std::vector<double> x(l2_numbers, 1.25);
  std::vector<double> y(l2_numbers, 1.25);
  double* to = y.data();
  benchmark::DoNotOptimize(to);
  MachinePeak peak;
  peak.l1 = rate(8.0 * l1_numbers, [&] { read_all(x.data(), l1_numbers, to); });
  peak.l2 = rate(8.0 * l2_numbers, [&] { read_all(x.data(), l2_numbers, to); });
  peak.l2_copy = rate(16.0 * l2_numbers, [&] { copy(x.data(), l2_numbers, to); });
  constexpr int times = 1000;
  peak.mul_add = rate(2.0 * chains * times, [&] { multiply_and_add(0.5, 0.7, times, to); });
  peak.square_root = rate(l1_numbers, [&] { square_roots(x.data(), l1_numbers, to); });
  peak.division = rate(l1_numbers, [&] { divisions(x.data(), l1_numbers, to); });
  return peak;
}

void machine_peak_rates(benchmark::State& run) {
  const MachinePeak& peak = machine_peak();
  for (auto _ : run) benchmark::DoNotOptimize(&peak);
  run.counters["L1 read B/s"] = peak.l1;
  run.counters["L2 read B/s"] = peak.l2;
  run.counters["L2 copy B/s"] = peak.l2_copy;
  run.counters["mul,add /s"] = peak.mul_add;
  run.counters["sqrt /s"] = peak.square_root;
  run.counters["div /s"] = peak.division;
}
BENCHMARK(machine_peak_rates);

}  // namespace

const MachinePeak& machine_peak() {
  static const MachinePeak peak = measure();
  return peak;
}

}  // namespace clothsim
