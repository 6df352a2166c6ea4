#pragma once

#include <string>

namespace clothsim {

/// Folders of this package's files: beside the installed library, or the sources it was built from.
/// Throw std::runtime_error where there are neither.
std::string shaders_folder();
std::string textures_folder();

}  // namespace clothsim
