#pragma once

#include <optional>
#include <string>
#include <vector>

namespace clothsim::work_precision {

/// A finished run, for the assessment of `auto`.
struct Contender {
  std::string method;  // by its name in `auto`
  double cost;         // [CPU ms per simulated second]
  double error;        // of positions, of the size; not below that of the reference
};

/// The most accurate of `runs` by methods other than that of `chosen` that cost no more: the best
/// alternative for `auto`. None where all of those cost more.
std::optional<Contender> best_passed_over(const Contender& chosen,
                                          const std::vector<Contender>& runs);

}  // namespace clothsim::work_precision
