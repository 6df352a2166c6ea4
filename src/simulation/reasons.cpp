#include "clothsim/simulation/reasons.h"

#include <cassert>

namespace clothsim {
namespace {

const char* clause_of(Reason reason) {
  switch (reason) {
    case Reason::named_by_scene:
      return "named by the scene";
    case Reason::no_springs:
      return "no springs to integrate";
    case Reason::error_not_predicted:
      return "no error can be foretold without gravity, or as a stiff cloth rings: of the methods "
             "in real time an explicit one, else one that does not soften springs";
    case Reason::cheapest_within_tolerance:
      return "the cheapest within tolerance";
    case Reason::most_accurate_in_real_time:
      return "none is within tolerance in real time: the most accurate in real time";
    case Reason::none_in_real_time:
      return "none is in real time: the cheapest";
    case Reason::none_stable:
      return "no method is stable with so few substeps";
    case Reason::softens:
      return "xpbd lets the cloth stretch where it hangs from an edge, and more at a corner:";
    case Reason::method_failed:
      return "a frame failed with";
    case Reason::failed_before_set_state:
      return "a frame failed before the state that was set";
    case Reason::beyond_stability:
      return "so few substeps are beyond the method's stability limit";
    case Reason::newton_unconverged:
      return "Newton's method ran out of iterations";
    case Reason::limit_yields:
      return "the strain limit yields: colliders or holders pull with more than a step can carry";
    case Reason::passes_unconverged:
      return "passes ran out before every spring was within its strain limit";
    case Reason::crosses_itself:
      return "the cloth crosses itself since its state was set, which untangle may mend:";
  }
  assert(false);
  return "";
}

}  // namespace

void Reasons::add(Reason reason, const std::string& detail) {
  all_.insert(reason);
  if (!text_.empty()) text_ += "; ";
  text_ += clause_of(reason);
  if (!detail.empty()) text_ += " " + detail;
}

}  // namespace clothsim
