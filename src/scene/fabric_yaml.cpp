#include "clothsim/scene/fabric_yaml.h"

#include <algorithm>
#include <filesystem>

#include "clothsim/model/checks.h"
#include "clothsim/model/package.h"
#include "clothsim/model/resource.h"
#include "clothsim/scene/scene_yaml.h"

namespace clothsim {
namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, 6> fabric_keys = {"fabric",           "stretch_stiffness",
                                                    "shear_stiffness",  "bending_stiffness",
                                                    "internal_damping", "poisson"};

/// The file of a fabric: a path that ends in .yaml, relative to `folder`, or a name in
/// config/fabrics of the package. Throws InvalidValue, which lists the names.
std::string fabric_file(const std::string& name, const fs::path& folder) {
  const std::string ending = ".yaml";
  if (name.size() > ending.size() && name.substr(name.size() - ending.size()) == ending) {
    const fs::path path = find_resource(name, folder);
    std::error_code error;
    if (fs::is_regular_file(path, error)) return path.string();
    throw InvalidValue({}, '"' + path.string() + "\", which is not there",
                       "the name or the file of a fabric");
  }
  std::vector<std::string> known;
  for (const auto& entry : fs::directory_iterator(package_folder("config/fabrics"))) {
    if (entry.path().extension() != ending) continue;
    if (entry.path().stem() == name) return entry.path().string();
    known.push_back(entry.path().stem().string());
  }
  std::sort(known.begin(), known.end());
  throw InvalidValue({}, '"' + name + '"', "one of " + join(known) + ", or a path of a .yaml file");
}

/// Reads the values of a fabric's file.
void read_fabric_file(const std::string& path, ClothSpec& cloth) {
  std::string source, date;
  std::vector<Field> fields = {{"source", into(source)}, {"date", into(date)}};
  for (auto& list : {fabric_fields(cloth.material.fabric.value()), material_fields(cloth)}) {
    fields.insert(fields.end(), list.begin(), list.end());
  }
  const YAML::Node map = load_scene_file(path);
  inside(path, [&] {
    read_map(map, fields);
    for (const auto& [key, text] : {std::pair("source", source), std::pair("date", date)}) {
      if (text.empty()) throw InvalidValue({key}, "nothing", "where its values are from");
    }
    validate(cloth.material);
  });
}

}  // namespace

std::vector<Field> material_fields(ClothSpec& cloth) {
  Material& material = cloth.material;
  return {{"density", into(material.density)},  {"damping", into(material.damping)},
          {"drag", into(material.drag)},        {"strain_limit", into(material.strain_limit)},
          {"thickness", into(cloth.thickness)}, {"friction", into(cloth.friction)}};
}

std::vector<Field> fabric_fields(Fabric& fabric) {
  return {{"stretch_stiffness", into(fabric.stretch_stiffness)},
          {"shear_stiffness", into(fabric.shear_stiffness)},
          {"bending_stiffness", into(fabric.bending_stiffness)},
          {"internal_damping", into(fabric.internal_damping)},
          {"poisson", into(fabric.poisson)}};
}

std::vector<Field> live_fields(Material& material) {
  std::vector<Field> fields = {
      {"springs", [&material](const YAML::Node& map) { read_springs(map, material.springs); }},
      {"density", into(material.density)},
      {"damping", into(material.damping)},
      {"drag", into(material.drag)},
      {"strain_limit", into(material.strain_limit)}};
  if (material.fabric) {
    append(fabric_fields(*material.fabric), fields);
  } else {
    fields.push_back({"ks", into(material.ks)});
  }
  return fields;
}

bool names_fabric(const YAML::Node& cloth) {
  return cloth.IsMap() && std::any_of(fabric_keys.begin(), fabric_keys.end(),
                                      [&](const char* key) { return cloth[key].IsDefined(); });
}

void start_fabric(const YAML::Node& map, const fs::path& folder, ClothSpec& cloth) {
  if (map["ks"]) {
    throw InvalidValue({"ks"}, describe(map["ks"]),
                       "none beside a fabric: its stiffness is stretch_stiffness");
  }
  cloth.material.fabric.emplace();
  cloth.material.damping = 0;
  cloth.material.strain_limit.reset();
  if (!map["fabric"]) return;
  inside("fabric", [&] { read_fabric_file(fabric_file(read_text(map["fabric"]), folder), cloth); });
}

}  // namespace clothsim
