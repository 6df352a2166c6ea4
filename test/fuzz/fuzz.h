#pragma once

#include <cstdint>
#include <functional>

namespace clothsim::testing {

/// Attacks where the command line does not say how many: a few seconds of them. Each fuzzer has its
/// own.
extern const int usual_count;

/// Runs `attack` for one seed after the other, as the command line asks for, telling each before it
/// begins. A seed that fails or throws is told with how to run it again, and the next one begins.
void for_each_seed(const std::function<void(std::uint64_t)>& attack);

/// Whether the seed that runs has failed.
bool has_failed();

/// Processor time of this program [s].
double cpu_seconds();

}  // namespace clothsim::testing
