#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

#include "clothsim/scene/scene.h"

namespace clothsim {

/// Valid values of a scene that are probably mistakes, each as a line for a log with the probable
/// meaning: angles in degrees, sizes in centimetres, a cloth that starts in a collider. `root`: the
/// scene's YAML.
std::vector<std::string> doubts(const YAML::Node& root, const Scene&);

}  // namespace clothsim
