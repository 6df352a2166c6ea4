#pragma once

#include <string>

#include "clothsim/scene/urdf.h"

namespace clothsim {

/// Reads the one model of an SDF as the URDF that describes the same. Its root is `world`: a fixed
/// joint leads there to each link of a static model, and a floating one to each other link that no
/// joint leads to. A joint whose frame is not that of its child leads to a link of its own name.
/// The poses of links follow from the joints, see read_urdf(). An error in one collision goes into
/// its `fault`. Throws InvalidValue, without a key, for a text that libsdformat refuses, and for
/// one with worlds or models inside a model.
Urdf read_sdf(const std::string& text);

/// The refused value and the expected one.
struct SdfRefusal {
  std::string got;
  std::string expected;
};

}  // namespace clothsim

/// The reader in the library clothsim_sdf, which read_sdf() loads. Returns false for a refusal.
extern "C" bool clothsim_read_sdf(const std::string& text, clothsim::Urdf&, clothsim::SdfRefusal&);
