#include "clothsim/scene/sdf.h"

#include "clothsim/model/checks.h"
#include "clothsim/model/module.h"

namespace clothsim {

Urdf read_sdf(const std::string& text) {
  static const auto reader = reinterpret_cast<decltype(&clothsim_read_sdf)>(
      load_function("clothsim_sdf", "clothsim_read_sdf"));
  Urdf urdf;
  SdfRefusal refusal;
  if (reader(text, urdf, refusal)) return urdf;
  throw InvalidValue({}, shortened(refusal.got, 300), refusal.expected);
}

}  // namespace clothsim
