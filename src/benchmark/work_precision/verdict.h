#pragma once

#include <optional>
#include <string>
#include <vector>

namespace clothsim::work_precision {

/// A run that was done, as a judge of `auto` sees it.
struct Contender {
  std::string method;  // as `auto` would name it
  double cost;         // [CPU ms per simulated second]
  double error;        // of positions, of the size; where the reference cannot tell, what it can
};

/// The most exact of `runs` by methods other than that of `chosen` which cost no more than it: what
/// `auto` has passed over. None where all of those are dearer.
std::optional<Contender> best_passed_over(const Contender& chosen,
                                          const std::vector<Contender>& runs);

}  // namespace clothsim::work_precision
