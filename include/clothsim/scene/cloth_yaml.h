#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>

#include "clothsim/model/cloth_spec.h"

namespace clothsim {

/// Reads the map `cloth` of a scene. Relative files are in `folder`. Throws InvalidValue.
ClothSpec read_cloth(const YAML::Node&, const std::filesystem::path& folder);

/// Reads the list `cloths` of a scene, each a map as of `cloth` with a `name`: see join_cloths().
/// Self collision, which is also contact of one cloth with another, is on unless they switch it
/// off. Throws InvalidValue.
ClothSpec read_cloths(const YAML::Node&, const std::filesystem::path& folder);

/// true, false, or a name of self_collision_names.
void read_self_collision(const YAML::Node&, SelfCollision&);

}  // namespace clothsim
