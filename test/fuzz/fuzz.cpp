// The command line of the fuzzers: FUZZER [--seed S] [--count N] [--seconds T].

#include "fuzz/fuzz.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <ctime>
#include <iostream>
#include <string>

namespace clothsim::test {
namespace {

struct Options {
  std::uint64_t seed = 1;
  int count = usual_count;
  double seconds = 0;
};

Options options;
std::string program;

/// Failures of the running test.
int failures() {
  return ::testing::UnitTest::GetInstance()->current_test_info()->result()->total_part_count();
}

int failures_before = 0;

void run_one(const std::function<void(std::uint64_t)>& attack, std::uint64_t seed) {
  const std::string number = std::to_string(seed);
  SCOPED_TRACE("seed " + number + ", again by: " + program + " --count 1 --seed " + number);
  std::cout << "seed " << number << ": " << std::flush;
  failures_before = failures();
  try {
    attack(seed);
  } catch (const std::exception& error) {
    ADD_FAILURE() << "threw: " << error.what();
  }
  std::cout << std::endl;
}

}  // namespace

void for_each_seed(const std::function<void(std::uint64_t)>& attack) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(options.seconds);
  const auto goes_on = [&](int done) {
    return options.seconds > 0 ? Clock::now() < end : done < options.count;
  };
  for (int done = 0; goes_on(done); ++done) {
    run_one(attack, options.seed + static_cast<std::uint64_t>(done));
  }
}

bool has_failed() { return failures() > failures_before; }

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace clothsim::test

int main(int argc, char** argv) {
  using clothsim::test::options;
  ::testing::InitGoogleTest(&argc, argv);
  clothsim::test::program = argv[0];
  CLI::App app("Attacks the simulator at random. Equal seeds attack alike.");
  app.add_option("--seed", options.seed, "of the first attack")->capture_default_str();
  app.add_option("--count", options.count, "attacks")->capture_default_str();
  app.add_option("--seconds", options.seconds, "attack for so long, whatever the count");
  CLI11_PARSE(app, argc, argv);
  return RUN_ALL_TESTS();
}
