#include "clothsim/model/resource.h"

#include <cctype>
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <optional>
#include <regex>
#include <sstream>
#include <string_view>

#include "clothsim/model/checks.h"
#include "clothsim/model/package.h"

namespace clothsim {
namespace {

namespace fs = std::filesystem;

constexpr const char* package_scheme = "package://";
constexpr const char* file_scheme = "file://";

/// Depth to which the folders of ROS_PACKAGE_PATH are searched for packages.
constexpr int deepest = 4;

bool starts_with(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

/// The name in a folder's package.xml; empty: there is none.
std::string package_in(const fs::path& folder) {
  std::ifstream file(folder / "package.xml");
  if (!file) return "";
  std::stringstream text;
  text << file.rdbuf();
  static const std::regex name(R"(<name>\s*([^<\s]+)\s*</name>)");
  const std::string manifest = text.str();
  std::smatch found;
  return std::regex_search(manifest, found, name) ? found[1].str() : "";
}

/// A URI with its escapes, such as %20, replaced by their characters.
std::string unescaped(const std::string& text) {
  const auto is_hex = [&text](std::size_t i) {
    return i < text.size() && std::isxdigit(static_cast<unsigned char>(text[i])) != 0;
  };
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool is_escape = text[i] == '%' && is_hex(i + 1) && is_hex(i + 2);
    plain += is_escape ? static_cast<char>(std::stoi(text.substr(i + 1, 2), nullptr, 16)) : text[i];
    if (is_escape) i += 2;
  }
  return plain;
}

/// A path as the text of a URI: letters, digits and a few marks remain as they are.
std::string escaped(const std::string& path) {
  constexpr std::string_view marks = "/-._~";
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << std::hex << std::uppercase << std::setfill('0');
  for (const char c : path) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_plain = byte < 128 && std::isalnum(byte) != 0;
    if (is_plain || marks.find(c) != std::string_view::npos) {
      text << c;
    } else {
      text << '%' << std::setw(2) << static_cast<int>(byte);
    }
  }
  return text.str();
}

/// Packages do not contain packages.
std::optional<fs::path> find_below(const fs::path& folder, const std::string& name, int depth) {
  std::error_code error;
  if (fs::exists(folder / "CATKIN_IGNORE", error)) return {};
  const std::string here = package_in(folder);
  if (here == name) return folder;
  if (!here.empty() || depth == 0) return {};
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (!entry.is_directory(error)) continue;
    if (const auto found = find_below(entry.path(), name, depth - 1)) return found;
  }
  return {};
}

/// The folder of a ROS package: in ROS_PACKAGE_PATH, or where Debian installs packages. Throws
/// InvalidValue, without a key, for an unknown package.
fs::path find_package(const std::string& name) {
  const char* path = std::getenv("ROS_PACKAGE_PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (folder.empty()) continue;
    if (const auto found = find_below(folder, name, deepest)) return *found;
  }
  const fs::path of_debian = fs::path("/usr/share") / name;
  if (package_in(of_debian) == name) return of_debian;
  if (name == "clothsim") return fs::path(package_folder("config")).parent_path();
  throw InvalidValue({}, "the package " + shortened(name, 100) + ", which is not there",
                     "a package in ROS_PACKAGE_PATH");
}

}  // namespace

fs::path find_resource(const std::string& name, const fs::path& folder) {
  if (starts_with(name, package_scheme)) {
    const std::string rest = name.substr(std::string(package_scheme).size());
    const std::size_t slash = rest.find('/');
    if (slash == 0 || slash == std::string::npos || slash + 1 == rest.size()) {
      throw InvalidValue({}, '"' + shortened(name, 200) + '"', "package://PACKAGE/path");
    }
    return find_package(rest.substr(0, slash)) / unescaped(rest.substr(slash + 1));
  }
  if (starts_with(name, file_scheme))
    return unescaped(name.substr(std::string(file_scheme).size()));
  if (name.find("://") != std::string::npos) {
    throw InvalidValue({}, '"' + shortened(name, 200) + '"', "package://, file:// or a path");
  }
  return folder / name;
}

std::string uri_of(const std::string& name, const fs::path& found) {
  if (starts_with(name, package_scheme)) {
    return package_scheme + escaped(unescaped(name.substr(std::string(package_scheme).size())));
  }
  std::error_code error;
  return file_scheme + escaped(fs::weakly_canonical(found, error).string());
}

}  // namespace clothsim
