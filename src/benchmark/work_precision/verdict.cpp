#include "verdict.h"

namespace clothsim::work_precision {

std::optional<Contender> best_passed_over(const Contender& chosen,
                                          const std::vector<Contender>& runs) {
  std::optional<Contender> best;
  for (const Contender& run : runs) {
    if (run.method == chosen.method || run.cost > chosen.cost) continue;
    if (!best || run.error < best->error) best = run;
  }
  return best;
}

}  // namespace clothsim::work_precision
