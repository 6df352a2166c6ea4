#pragma once

#include <filesystem>
#include <string>

namespace clothsim {

/// The folder of a ROS package: in ROS_PACKAGE_PATH, or where Debian has them. Throws InvalidValue,
/// without a key, for one that is not there.
std::filesystem::path find_package(const std::string& name);

/// The file that a name means: package://PACKAGE/path, file:///path, an absolute path or one from
/// `folder` on. Blanks and the like in the first two may be as they are or escaped, as %20. It need
/// not be there. Throws InvalidValue, without a key, for an unknown package or
/// another kind of name.
std::filesystem::path find_resource(const std::string& name, const std::filesystem::path& folder);

/// The name by which other programs find it, escaped: package://... where that is the name, else
/// file:///...
std::string uri_of(const std::string& name, const std::filesystem::path& found);

}  // namespace clothsim
