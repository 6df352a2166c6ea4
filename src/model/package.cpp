#include "clothsim/model/package.h"

#include <dlfcn.h>

#include <filesystem>
#include <stdexcept>

namespace clothsim {

namespace fs = std::filesystem;

std::optional<std::string> find_installed(const std::string& library, const std::string& name) {
  // Libraries are in PREFIX/lib, in PREFIX/lib/x86_64-linux-gnu and the like, or, with pip, in a
  // Python package with all its files.
  const fs::path lib = fs::weakly_canonical(library).parent_path();
  for (const fs::path& prefix : {lib, lib.parent_path(), lib.parent_path().parent_path()}) {
    const fs::path folder = prefix / "share" / "clothsim" / name;
    if (fs::is_directory(folder)) return folder.string();
  }
  return {};
}

std::string package_folder(const std::string& name) {
  Dl_info library{};
  if (dladdr(reinterpret_cast<const void*>(&package_folder), &library) != 0) {
    if (const auto installed = find_installed(library.dli_fname, name)) return *installed;
  }
  // A build from sources.
  const fs::path source = fs::path(CLOTHSIM_SOURCE_DIR) / name;
  if (fs::is_directory(source)) return source.string();
  throw std::runtime_error("the package's folder " + name +
                           " is neither installed beside the library nor at " + source.string());
}

}  // namespace clothsim
