#include "clothsim/model/workers.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <new>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "clothsim/constraints/self_contacts.h"
#include "clothsim/constraints/strain_limit.h"
#include "verification/testing.h"

namespace clothsim::workers_test {
namespace {

using namespace test;

int threads_now() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word == "Threads:") {
      int count = 0;
      status >> count;
      return count;
    }
  }
  return 0;
}

TEST(Workers, ShareEveryElementOnce) {
  for (const int threads : {1, 2, 3, 7}) {
    const Workers workers(threads);
    EXPECT_EQ(workers.threads(), threads);
    for (const int bands_a_thread : {1, Workers::uneven}) {
      for (const int count : {0, 1, 7, 8, 9, 1000, 4097}) {
        std::vector<int> visits(static_cast<std::size_t>(count), 0);
        std::atomic<int> bands{0};
        workers.parallel_for(
            count,
            [&](int begin, int end) {
              ++bands;
              for (int i = begin; i < end; ++i) ++visits[static_cast<std::size_t>(i)];
            },
            8, bands_a_thread);
        EXPECT_EQ(visits, std::vector<int>(static_cast<std::size_t>(count), 1)) << count;
        const int most = threads == 1 ? 1 : threads * bands_a_thread;
        EXPECT_LE(bands, most);
        if (count >= 8 * most) {
          EXPECT_EQ(bands, most) << count;
        }
      }
    }
  }
}

TEST(Workers, ShareBandsShorterThanALineOfTheCaches) {
  const Workers workers(2);
  std::array<std::atomic<int>, 2> lengths{};
  workers.parallel_for(
      2, [&](int begin, int end) { lengths[static_cast<std::size_t>(begin)] = end - begin; }, 1);
  EXPECT_EQ(lengths[0], 1);
  EXPECT_EQ(lengths[1], 1);
}

TEST(Workers, StagesBeginWhenEarlierOnesHaveEnded) {
  const std::vector<int> ends{5, 6, 6, 26, 30};
  for (const int threads : {1, 2, 3, 7}) {
    const Workers workers(threads);
    for (int loop = 0; loop < 200; ++loop) {
      std::vector<std::atomic<int>> ended(ends.size());  // by stage
      std::atomic<int> too_early{0};
      workers.in_stages(ends, [&](int part) {
        std::size_t stage = 0;
        for (; part >= ends[stage]; ++stage) {
          const int parts = ends[stage] - (stage > 0 ? ends[stage - 1] : 0);
          too_early += ended[stage] < parts;
        }
        ++ended[stage];
      });
      EXPECT_EQ(too_early, 0);
      EXPECT_EQ(ended[0] + ended[1] + ended[3] + ended[4], ends.back());
    }
  }
}

TEST(Workers, NoPartsInStages) {
  Workers(3).in_stages({0, 0}, [](int) { FAIL(); });
}

TEST(Workers, EndWhateverTheirThreadsDo) {
  // The pool ends while threads wake up, look for work, take it or have just missed it.
  std::atomic<int> bands{0};
  constexpr int rounds = 30000;
  for (int k = 0; k < rounds; ++k) {
    const Workers workers(2);
    workers.parallel_for(
        16, [&](int, int) { ++bands; }, 8);
  }
  EXPECT_EQ(bands, 2 * rounds);
}

TEST(Workers, ManyLoopsInARowAndAfterASleep) {
  const Workers workers(3);
  std::vector<double> sums(3000, 0);
  for (int loop = 0; loop < 3000; ++loop) {
    workers.parallel_for(
        3000,
        [&](int begin, int end) {
          for (int i = begin; i < end; ++i) sums[static_cast<std::size_t>(i)] += 1;
        },
        1);
    if (loop % 1000 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(sums, std::vector<double>(3000, 3000));
}

/// Number of threads of this process: `expected`, or the number a second later. For a moment the
/// kernel still counts a thread that has been joined.
int threads_or(int expected) {
  for (int wait = 0; wait < 1000 && threads_now() != expected; ++wait) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return threads_now();
}

TEST(Workers, OneThreadStartsNoneAndManyEnd) {
  const int before = threads_now();
  ASSERT_GT(before, 0);
  Scene scene = shipped_scene("pinned2");
  {
    Simulator simulator(scene);
    simulator.step();
    EXPECT_EQ(threads_or(before), before);

    SimulationSpec simulation = scene.simulation;
    simulation.threads = 3;
    simulator.set_simulation(simulation);
    simulator.step();
    EXPECT_EQ(threads_or(before + 2), before + 2);
    simulation.threads = 1;
    simulator.set_simulation(simulation);
    EXPECT_EQ(threads_or(before), before);
  }
  scene.simulation.threads = 4;
  { const Simulator simulator(scene); }
  EXPECT_EQ(threads_or(before), before);
}

/// So many frames of a scene are the same with one, two and three threads.
void expect_same_bits(Scene scene, int frames) {
  const auto run_with = [&](int threads) {
    scene.simulation.threads = threads;
    Simulator simulator(scene);
    for (int frame = 0; frame < frames; ++frame) simulator.step();
    return simulator.state();
  };
  const State one = run_with(1);
  for (const int threads : {2, 3}) {
    const State state = run_with(threads);
    EXPECT_EQ(state.positions, one.positions) << threads;
    EXPECT_EQ(state.velocities, one.velocities) << threads;
  }
}

/// Every method, in a scene with all features, takes the same steps with any number of threads.
class MethodThreadBits : public ::testing::TestWithParam<std::string> {};

TEST_P(MethodThreadBits, AreTheSame) {
  for (const char* name : {"pinned2", "sphere"}) {
    Scene scene = shipped_scene(name);
    // Wide enough for three threads; Newton's method is slow and has one.
    const bool has_one = GetParam() == ImplicitEuler::name || GetParam() == Bdf2::name;
    const int side = has_one ? 12 : 60;
    scene.cloth.columns = scene.cloth.rows = side;
    for (Pin& pin : scene.cloth.pinned) pin.column = pin.column == 0 ? 0 : side - 1;
    scene.simulation.method = GetParam();
    SCOPED_TRACE(name);
    expect_same_bits(scene, 5);
  }
}

/// The same for Verlet's other precision, with pins, strain limit and contact.
TEST(ThreadBits, AreTheSameInSinglePrecision) {
  using Parameters = VelocityVerlet::Parameters;
  for (const char* name : {"pinned2", "sphere", "self_collision"}) {
    Scene scene = shipped_scene(name);
    scene.simulation.method = VelocityVerlet::name;
    const auto run_with = [&](Parameters::Precision precision, int threads) {
      scene.simulation.method_parameters = Parameters{precision};
      scene.simulation.threads = threads;
      Simulator simulator(scene);
      for (int frame = 0; frame < 20; ++frame) {
        EXPECT_LT(simulator.step().worst_stretch, 0.1041) << name;
      }
      return simulator.state();
    };
    const State one = run_with(Parameters::single_precision, 1);
    EXPECT_EQ(one.positions, run_with(Parameters::single_precision, 3).positions) << name;
    const double off =
        (one.positions - run_with(Parameters::double_precision, 1).positions).cwiseAbs().maxCoeff();
    EXPECT_GT(off, 0) << name;
    // Rounding decides on one pass more or less, each within the limit's tolerance: 0.08 mm a
    // spring.
    EXPECT_LT(off, 5e-4) << name;
  }
}

/// All springs over their limit: so many of each colour that threads share them.
TEST(ThreadBits, AreTheSameFromTheStrainLimit) {
  ClothSpec spec;
  spec.columns = spec.rows = 110;
  spec.material.strain_limit = 0.02;
  const Cloth cloth = make_grid(spec);
  const double h = 1e-3;
  const auto solved = [&](const Workers& workers, bool pass_by_pass) {
    State state{1.05 * shaken(cloth, 1e-4, 1), random_points(cloth.num_points(), 0.1, 2), 0};
    StrainLimit limit(cloth);
    limit.warm_start(h, 1, state, workers);
    if (pass_by_pass) {
      limit.prepare(cloth, 1, state, workers);
      for (int pass = 0; pass < 5; ++pass) limit.solve_pass(state.velocities, workers);
    } else {
      EXPECT_EQ(limit.solve(cloth, 1, 1e-12, 4, 20, state, workers).count, 20);
    }
    EXPECT_TRUE(limit.shares_passes());
    limit.learn_tension(workers);
    limit.warm_start(h, 1, state, workers);
    EXPECT_EQ(limit.project_positions(cloth, 1e-3, 10, state.positions, workers), 10);
    return state;
  };
  for (const bool pass_by_pass : {false, true}) {
    const State expected = solved(Workers(), pass_by_pass);
    for (const int threads : {2, 3}) {
      const State state = solved(Workers(threads), pass_by_pass);
      EXPECT_EQ(state.positions, expected.positions) << threads;
      EXPECT_EQ(state.velocities, expected.velocities) << threads;
    }
  }
}

/// Memory of this process, including what it has only reserved [bytes].
rlim_t address_space() {
  rlim_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
}

TEST(Workers, WithoutMemoryForTheirThreadsThrow) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers need more memory";
#endif
  const auto start_too_many = [] {
    const rlim_t limit = address_space() + (rlim_t{16} << 20);  // 64 stacks take more
    const rlimit limits{limit, limit};
    if (setrlimit(RLIMIT_AS, &limits) != 0) std::_Exit(1);
    try {
      Workers workers(64);
    } catch (const std::system_error&) {
      std::_Exit(0);
    }
    std::_Exit(2);
  };
  EXPECT_EXIT(start_too_many(), ::testing::ExitedWithCode(0), "");
}

TEST(Workers, ThrowWhatABodyHasThrown) {
  const Workers workers(3);
  for (int bad = 0; bad < 8; ++bad) {
    std::atomic<int> parts{0};
    const auto run = [&] {
      workers.in_stages({4, 8}, [&](int part) {
        ++parts;
        if (part == bad) throw std::bad_alloc();
      });
    };
    EXPECT_THROW(run(), std::bad_alloc);
    EXPECT_EQ(parts, 8);  // no thread waits for the part that has failed
  }
  std::atomic<int> sum{0};
  workers.each(1000, [&](int k) { sum += k; });
  EXPECT_EQ(sum, 499500);
}

/// A pile whose contacts are found and solved by all threads.
TEST(ThreadBits, AreTheSameFromSurfaceContact) {
  Scene scene = shipped_scene("self_collision");
  scene.cloth.columns = scene.cloth.rows = 25;
  scene.cloth.self_collision = SelfCollision::surface;
  expect_same_bits(scene, 80);
}

/// Enough passes over contacts for either side of a cloth that lies folded in two.
TEST(ThreadBits, AreTheSameFromBothSidesOfAFold) {
  ClothSpec spec;
  spec.columns = spec.rows = 31;
  spec.thickness = 0.002;
  const Cloth cloth = make_grid(spec);
  const double h = 1e-3;
  const auto solved = [&](const Workers& workers) {
    State state{cloth.rest_positions, random_points(cloth.num_points(), 0.1, 1), 0};
    for (int i = 0; i < cloth.num_points(); ++i) {
      const int beyond = i % 31 - 16;
      if (beyond < 0) continue;
      state.positions.row(i) =
          cloth.rest_positions.row(i - 2 * beyond - 1) + Eigen::RowVector3d(3e-3, 2e-3, 3.9e-3);
    }
    const Points start = state.positions;
    SelfContacts contacts(cloth, SelfCollision::surface);
    contacts.prepare(cloth, {h, 1, start, state.velocities, workers}, state);
    for (int pass = 0; pass < 5; ++pass) contacts.solve_pass(0, state.velocities, workers);
    EXPECT_GT(contacts.count(), 200);
    return state.velocities;
  };
  const Points expected = solved(Workers());
  for (const int threads : {2, 3}) EXPECT_EQ(solved(Workers(threads)), expected) << threads;
}

std::vector<std::string> auto_and_methods() {
  std::vector<std::string> names = method_names();
  names.emplace_back("auto");
  return names;
}

INSTANTIATE_TEST_SUITE_P(Methods, MethodThreadBits, ::testing::ValuesIn(auto_and_methods()));

}  // namespace
}  // namespace clothsim::workers_test
