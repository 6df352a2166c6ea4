#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "clothsim/scene/motion.h"

namespace clothsim {

/// Reads key frames from a .csv or .npz file: times [s], positions [m], and orientations if there
/// are any. Throws InvalidValue with the path as key.
std::vector<MotionEntry> read_key_frames(const std::filesystem::path&, const std::string& frame);

}  // namespace clothsim
