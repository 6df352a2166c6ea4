#pragma once

#include <cstdint>
#include <functional>

namespace clothsim::testing {

/// Runs `attack` for one seed after the other, as the command line asks for, telling each before it
/// begins. A seed that fails or throws is told with how to run it again, and the next one begins.
void for_each_seed(const std::function<void(std::uint64_t)>& attack);

/// Whether the seed that runs has failed.
bool has_failed();

/// Processor time of this program [s].
double cpu_seconds();

}  // namespace clothsim::testing
