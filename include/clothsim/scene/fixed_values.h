#pragma once

#include <string>

#include "clothsim/scene/scene.h"

namespace clothsim {

/// The values of a scene that are not live values of the node, one "key: value" a line: two scenes
/// with equal texts run alike once their live values are equal. For a mesh only the file's name, as
/// its folder may differ on another computer.
std::string fixed_values(const Scene&);

}  // namespace clothsim
