#pragma once

#include <string>

#include "clothsim/scene/scene.h"

namespace clothsim {

/// What of a scene no live value of the node changes, one "key: value" a line: two scenes of equal
/// texts run alike once their live values are equal. Of a mesh it has the file's name alone, as
/// that may lie elsewhere on another computer.
std::string fixed_values(const Scene&);

}  // namespace clothsim
