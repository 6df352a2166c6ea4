#include "clothsim/model/module.h"

#include <dlfcn.h>

#include <filesystem>
#include <stdexcept>

namespace clothsim {

void* load_function(const std::string& library, const std::string& function) {
  Dl_info here{};
  std::filesystem::path folder;
  if (dladdr(reinterpret_cast<const void*>(&load_function), &here) != 0) {
    folder = std::filesystem::weakly_canonical(here.dli_fname).parent_path();
  }
  const std::string file = (folder / ("lib" + library + ".so")).string();
  void* loaded = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);  // and stays loaded
  void* found = loaded ? dlsym(loaded, function.c_str()) : nullptr;
  if (!found) throw std::runtime_error("a library cannot be loaded: " + std::string(dlerror()));
  return found;
}

}  // namespace clothsim
