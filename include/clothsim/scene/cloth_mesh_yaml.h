#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>

#include "clothsim/model/cloth_spec.h"

namespace clothsim {

/// Reads the map `mesh` of a scene's `cloth` into `cloth.mesh`, and sets its points in one row.
/// Relative files are in `folder`. Throws InvalidValue.
void read_cloth_mesh(const YAML::Node&, const std::filesystem::path& folder, ClothSpec& cloth);

}  // namespace clothsim
