#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <string>
#include <vector>

#include "clothsim/model/cloth_spec.h"
#include "clothsim/scene/yaml_values.h"

namespace clothsim {

/// The keys of a cloth's material, in a scene or in a fabric's file. The keys that a classic cloth
/// has, too:
std::vector<Field> material_fields(ClothSpec&);

/// The keys of a fabric.
std::vector<Field> fabric_fields(Fabric&);

/// The keys of a material that may change during the simulation.
std::vector<Field> live_fields(Material&);

/// Whether the map of a cloth in a scene names a fabric, or one of its values.
bool names_fabric(const YAML::Node& cloth);

/// Makes `cloth` a fabric before its map in a scene is read: without drag rate and strain limit,
/// then with the values of the file that the key `fabric` names. Throws InvalidValue for a map that
/// has `ks`, too, and for errors in the file.
void start_fabric(const YAML::Node& map, const std::filesystem::path& folder, ClothSpec& cloth);

}  // namespace clothsim
