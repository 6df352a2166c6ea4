#pragma once

#include <string>

#include "clothsim/model/package.h"

namespace clothsim {

/// Folders of this package's files, see package_folder().
std::string shaders_folder();
std::string textures_folder();

}  // namespace clothsim
