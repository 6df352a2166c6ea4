#include "clothsim/scene/sdf.h"

#include <dlfcn.h>

#include <filesystem>
#include <stdexcept>

#include "clothsim/model/checks.h"

namespace clothsim {
namespace {

/// The reader, from the library beside the one that this function is in. It stays loaded.
decltype(&clothsim_read_sdf) load_reader() {
  Dl_info here{};
  std::filesystem::path folder;
  if (dladdr(reinterpret_cast<const void*>(&read_sdf), &here) != 0) {
    folder = std::filesystem::weakly_canonical(here.dli_fname).parent_path();
  }
  const std::string file = (folder / "libclothsim_sdf.so").string();
  void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* reader = library ? dlsym(library, "clothsim_read_sdf") : nullptr;
  if (!reader)
    throw std::runtime_error("the reader of SDF cannot be loaded: " + std::string(dlerror()));
  return reinterpret_cast<decltype(&clothsim_read_sdf)>(reader);
}

}  // namespace

Urdf read_sdf(const std::string& text) {
  static const auto reader = load_reader();
  Urdf urdf;
  SdfRefusal refusal;
  if (reader(text, urdf, refusal)) return urdf;
  throw InvalidValue({}, shortened(refusal.got, 300), refusal.expected);
}

}  // namespace clothsim
