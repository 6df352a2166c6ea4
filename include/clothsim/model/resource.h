#pragma once

#include <filesystem>
#include <string>

namespace clothsim {

/// The file that a name refers to: package://PACKAGE/path, file:///path, an absolute path or one
/// relative to `folder`. Special characters in the first two may be escaped or not, as %20 for a
/// blank. The file need not exist. Throws InvalidValue, without a key, for an unknown package or
/// another kind of name.
std::filesystem::path find_resource(const std::string& name, const std::filesystem::path& folder);

/// The escaped URI of the file for other programs: package://... where `name` is one, else
/// file:///...
std::string uri_of(const std::string& name, const std::filesystem::path& found);

}  // namespace clothsim
