#pragma once

#include <optional>
#include <string>

namespace clothsim {

/// A folder of this package's files, such as "config/fabrics": beside the installed library, or in
/// the sources that it was built from. Throws std::runtime_error where there is neither.
std::string package_folder(const std::string& name);

/// share/clothsim/`name` below the prefix that the file `library` is installed in; empty: there is
/// none.
std::optional<std::string> find_installed(const std::string& library, const std::string& name);

}  // namespace clothsim
