#include "clothsim/view/resources.h"

#include <dlfcn.h>

#include <filesystem>
#include <stdexcept>

namespace clothsim {
namespace {

namespace fs = std::filesystem;

std::string find_folder(const fs::path& name) {
  // An installed package: lib/libclothsim_view.so beside share/clothsim.
  Dl_info library{};
  if (dladdr(reinterpret_cast<const void*>(&find_folder), &library) != 0) {
    const fs::path prefix = fs::weakly_canonical(library.dli_fname).parent_path().parent_path();
    const fs::path installed = prefix / "share" / "clothsim" / name;
    if (fs::is_directory(installed)) return installed.string();
  }
  // A build from sources.
  const fs::path source = fs::path(CLOTHSIM_SOURCE_DIR) / name;
  if (fs::is_directory(source)) return source.string();
  throw std::runtime_error("the package's folder " + name.string() +
                           " is neither installed beside the library nor at " + source.string());
}

}  // namespace

std::string shaders_folder() { return find_folder("shaders"); }
std::string textures_folder() { return find_folder("config/textures"); }

}  // namespace clothsim
