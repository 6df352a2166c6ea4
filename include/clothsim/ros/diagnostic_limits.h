#pragma once

#include <yaml-cpp/yaml.h>

#include <optional>

namespace clothsim_ros {

/// The values beyond which diagnostics report a warning and an error; empty: never.
struct Limit {
  std::optional<double> warning;
  std::optional<double> error;
};

/// All limits of the diagnostics, ~diagnostics of the parameters.
struct DiagnosticLimits {
  Limit speed{0.95, 0.5};      // least real-time factor, as a share of the requested one
  Limit violation{0.02, 0.1};  // most stretch beyond the strain limit, of the rest length
  Limit crossings{0, {}};      // most pairs of crossing triangles
  Limit tf_age{1, {}};         // of a tf frame's latest transform [s]
  Limit images{0.5, {}};       // least share of the due pictures that is drawn
};

/// Reads a map of the names above, each with `warning` and `error`, a number or off. Throws
/// InvalidValue, also where an error comes before its warning.
DiagnosticLimits read_diagnostic_limits(const YAML::Node&);

}  // namespace clothsim_ros
