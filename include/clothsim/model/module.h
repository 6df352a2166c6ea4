#pragma once

#include <string>

namespace clothsim {

/// A function of the library `library`, which lies beside the one with the core and is loaded at
/// its first use: for libraries that few scenes need. It has no symbols of the core, since the
/// core of the Python package of pip is no library. Throws std::runtime_error.
void* load_function(const std::string& library, const std::string& function);

}  // namespace clothsim
