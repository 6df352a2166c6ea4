#pragma once

#include <cstdint>
#include <functional>

namespace clothsim::test {

/// Default number of seeds where the command line gives none: a few seconds of work. Each fuzzer
/// defines its own.
extern const int usual_count;

/// Runs `attack` for a sequence of seeds, as the command line asks. Prints each seed before its
/// run. If a seed fails or throws, prints the command that repeats it and goes on with the next
/// seed.
void for_each_seed(const std::function<void(std::uint64_t)>& attack);

/// Whether the running seed has failed.
bool has_failed();

/// Processor time of this program [s].
double cpu_seconds();

}  // namespace clothsim::test
