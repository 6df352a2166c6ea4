#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

#include "clothsim/scene/scene.h"

namespace clothsim {

/// What of a scene is valid and hardly meant, each a line for a log with what may have been meant:
/// angles in degrees, sizes in centimetres, a cloth that starts in a collider. `root` is what the
/// scene was read from.
std::vector<std::string> doubts(const YAML::Node& root, const Scene&);

}  // namespace clothsim
