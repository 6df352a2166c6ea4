#pragma once

#include <optional>
#include <string>

#include "simulation.h"

namespace clothsim_python {

/// Throws InvalidValue.
void check_frame_name(const std::string& frame);

/// Puts a frame and its followers at a pose at once.
void place_frame(Run&, const std::string& frame, const clothsim::Pose&);

/// The pose of a frame or body; empty for an unknown one.
std::optional<clothsim::Pose> pose_now(const Run&, const std::string& frame);

}  // namespace clothsim_python
