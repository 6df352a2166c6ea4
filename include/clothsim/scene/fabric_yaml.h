#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <string>
#include <vector>

#include "clothsim/model/cloth_spec.h"
#include "clothsim/scene/yaml_values.h"

namespace clothsim {

/// The keys of a cloth that say what it is made of, in a scene or in a fabric's file. Those that a
/// classic cloth has too:
std::vector<Field> material_fields(ClothSpec&);

/// Those of a fabric.
std::vector<Field> fabric_fields(Fabric&);

/// Those of a material that may change while a cloth moves.
std::vector<Field> live_fields(Material&);

/// Whether the map of a cloth in a scene names a fabric, or one of its values.
bool names_fabric(const YAML::Node& cloth);

/// Makes `cloth` a fabric as its map in a scene begins: without drag rate and strain limit, then
/// with the values of the file that the key `fabric` names. Throws InvalidValue for a map that has
/// `ks` too, and for the file's mistakes.
void start_fabric(const YAML::Node& map, const std::filesystem::path& folder, ClothSpec& cloth);

/// The file of a fabric: a path that ends in .yaml, from `folder` on, or a name in config/fabrics
/// of the package. Throws InvalidValue, with the names that there are.
std::string fabric_file(const std::string& name, const std::filesystem::path& folder);

}  // namespace clothsim
