#include "clothsim/ros/diagnostic_limits.h"

#include <string>

#include "clothsim/model/checks.h"
#include "clothsim/scene/yaml_values.h"

namespace clothsim_ros {
namespace {

/// Whether the limit bounds from below or from above.
enum class Bound { lower, upper };

constexpr clothsim::Range range{0, 1e12, ""};

void check(const Limit& limit, Bound bound) {
  if (limit.warning) clothsim::check_range("warning", *limit.warning, range);
  if (limit.error) clothsim::check_range("error", *limit.error, range);
  if (!limit.warning || !limit.error) return;
  const bool in_order =
      bound == Bound::lower ? *limit.error <= *limit.warning : *limit.error >= *limit.warning;
  if (!in_order) {
    throw clothsim::InvalidValue({"error"}, clothsim::to_text(*limit.error),
                                 std::string(bound == Bound::lower ? "at most" : "at least") +
                                     " the limit of the warning, " +
                                     clothsim::to_text(*limit.warning));
  }
}

clothsim::ReadValue into(Limit& limit, Bound bound) {
  return [&limit, bound](const YAML::Node& node) {
    clothsim::read_map(
        node, {{"warning", clothsim::into(limit.warning)}, {"error", clothsim::into(limit.error)}});
    check(limit, bound);
  };
}

}  // namespace

DiagnosticLimits read_diagnostic_limits(const YAML::Node& node) {
  DiagnosticLimits limits;
  clothsim::read_map(node, {{"speed", into(limits.speed, Bound::lower)},
                            {"violation", into(limits.violation, Bound::upper)},
                            {"crossings", into(limits.crossings, Bound::upper)},
                            {"tf_age", into(limits.tf_age, Bound::upper)},
                            {"images", into(limits.images, Bound::lower)}});
  return limits;
}

}  // namespace clothsim_ros
