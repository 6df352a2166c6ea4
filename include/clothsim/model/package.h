#pragma once

#include <optional>
#include <string>

namespace clothsim {

/// A folder of this package's files, such as "config/fabrics": beside the installed library, or in
/// the source tree of the build. Throws std::runtime_error where there is neither.
std::string package_folder(const std::string& name);

/// share/clothsim/`name` below the prefix in which the file `library` is installed; empty: there is
/// none.
std::optional<std::string> find_installed(const std::string& library, const std::string& name);

}  // namespace clothsim
