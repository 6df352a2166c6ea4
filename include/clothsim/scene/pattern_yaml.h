#pragma once

#include <yaml-cpp/yaml.h>

#include "clothsim/model/cloth_spec.h"

namespace clothsim {

/// Reads the map `pattern` of a scene's `cloth` into `cloth.mesh` and `cloth.pattern`, and sets its
/// points in one row. Throws InvalidValue.
void read_pattern(const YAML::Node&, ClothSpec& cloth);

}  // namespace clothsim
