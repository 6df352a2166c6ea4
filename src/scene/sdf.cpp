#include "clothsim/scene/sdf.h"

#include <stdexcept>

#include "clothsim/model/checks.h"
#include "clothsim/model/module.h"

namespace clothsim {
namespace {

/// Throws InvalidValue where the library cannot be loaded.
decltype(&clothsim_read_sdf) load_reader() try {
  return reinterpret_cast<decltype(&clothsim_read_sdf)>(
      load_function("clothsim_sdf", "clothsim_read_sdf"));
} catch (const std::runtime_error& error) {
  throw InvalidValue({}, std::string("an SDF; ") + error.what(), "a URDF");
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
