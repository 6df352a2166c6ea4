#pragma once

#include <optional>
#include <string>

namespace clothsim {

/// Folders of this package's files: beside the installed library, or the sources it was built from.
/// Throw std::runtime_error where there are neither.
std::string shaders_folder();
std::string textures_folder();

/// share/clothsim/`name` below the prefix that the file `library` is installed in; empty: there is
/// none.
std::optional<std::string> find_installed(const std::string& library, const std::string& name);

}  // namespace clothsim
