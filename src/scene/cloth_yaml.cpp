#include "clothsim/scene/cloth_yaml.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "clothsim/geometry/cloth_surface.h"
#include "clothsim/model/checks.h"
#include "clothsim/model/join_cloths.h"
#include "clothsim/scene/cloth_mesh_yaml.h"
#include "clothsim/scene/fabric_yaml.h"
#include "clothsim/scene/pattern_yaml.h"
#include "clothsim/scene/points_yaml.h"
#include "clothsim/scene/scene_yaml.h"
#include "clothsim/scene/yaml_values.h"

namespace clothsim {
namespace {

/// A point, or a map with points and the tf frame that moves them.
void read_pins(const YAML::Node& node, PointReader& reader, std::vector<Pin>& pins) {
  Pin pin;
  PointPlace place;
  std::vector<std::array<int, 2>> points;
  const auto read_point = [&](const YAML::Node& point) {
    if (point.IsMap()) throw InvalidValue({}, describe(point), "[column, row]");
    points = reader.read(point);
  };
  if (!node.IsMap()) {
    read_point(node);
  } else {
    std::vector<Field> all = fields(place);
    append({{"point", read_point}, {"frame", into(pin.frame)}, {"strength", into(pin.strength)}},
           all);
    read_map(node, all);
    if (points.empty() == place.empty()) {
      throw InvalidValue({"point"}, points.empty() ? "nothing" : "a place, too",
                         "[column, row], or near, within and of, uv, corner or side instead");
    }
    if (points.empty()) points = reader.find(place);
  }
  for (const auto& [column, row] : points) {
    pin.column = column;
    pin.row = row;
    // Sides of a pattern share points.
    const bool is_known = place.side && std::any_of(pins.begin(), pins.end(), [&](const Pin& p) {
                            return p.column == column && p.row == row && p.frame == pin.frame &&
                                   p.strength == pin.strength;
                          });
    if (!is_known) pins.push_back(pin);
  }
}

/// Appends the points of an item. Sides of a pattern share points, which count once.
void append_points(const YAML::Node& item, const std::vector<std::array<int, 2>>& named,
                   std::vector<std::array<int, 2>>& points) {
  const bool is_side = item.IsMap() && item["side"].IsDefined();
  for (const std::array<int, 2>& point : named) {
    if (is_side && std::find(points.begin(), points.end(), point) != points.end()) continue;
    points.push_back(point);
  }
}

BodyPoints read_attached(const YAML::Node& node, PointReader& points) {
  BodyPoints attached;
  const auto read_points = [&](const YAML::Node& list) {
    read_list(list, [&](const YAML::Node& item) {
      append_points(item, points.read(item), attached.points);
    });
  };
  read_map(node, {{"body", into(attached.body)},
                  {"points", read_points},
                  {"tear_force", into(attached.tear_force)}});
  return attached;
}

/// Reads the pins and the points on bodies of a cloth that is known otherwise.
void read_points(const std::optional<YAML::Node>& pinned, const std::optional<YAML::Node>& attached,
                 ClothSpec& cloth) {
  if (pinned || attached) validate(cloth);
  PointReader points(cloth);
  const auto read_pin = [&](const YAML::Node& item) { read_pins(item, points, cloth.pinned); };
  const auto read_body = [&](const YAML::Node& item) {
    cloth.attached.push_back(read_attached(item, points));
  };
  if (pinned) inside("pinned", [&] { read_list(*pinned, read_pin); });
  if (attached) inside("attached", [&] { read_list(*attached, read_body); });
}

/// Throws InvalidValue where a cloth with a mesh or a pattern has a key of grids, or both.
void check_no_grid(const YAML::Node& node) {
  if (!node.IsMap()) return;
  const std::map<std::string, std::string> placed_by = {
      {"mesh", "a mesh, which mesh.pose places"},
      {"pattern", "a pattern, which the poses of its panels place"}};
  for (const auto& [shape, text] : placed_by) {
    if (!node[shape]) continue;
    for (const std::string key :
         {"width", "height", "columns", "rows", "orientation", "origin", "mesh"}) {
      if (!node[key] || key == shape) continue;
      throw InvalidValue({key}, describe(node[key]), "none with " + text);
    }
  }
}

/// Reads the map of a cloth; one of several has a `name`, too.
ClothSpec read(const YAML::Node& node, const std::filesystem::path& folder, std::string* name) {
  check_no_grid(node);
  ClothSpec cloth;
  Material& material = cloth.material;
  const auto read_orientation = [&](const YAML::Node& value) {
    cloth.orientation = static_cast<Orientation>(read_choice(value, {"horizontal", "vertical"}));
  };
  std::optional<YAML::Node> pinned, attached;  // read when the cloth is known
  std::vector<Field> fields = {
      {"mesh", [&](const YAML::Node& map) { read_cloth_mesh(map, folder, cloth); }},
      {"pattern", [&](const YAML::Node& map) { read_pattern(map, cloth); }},
      {"width", into(cloth.width)},
      {"height", into(cloth.height)},
      {"columns", into(cloth.columns)},
      {"rows", into(cloth.rows)},
      {"orientation", read_orientation},
      {"origin", into(cloth.origin)},
      {"pinned", [&](const YAML::Node& list) { pinned = list; }},
      {"attached", [&](const YAML::Node& list) { attached = list; }},
      {"pin_strength", into(cloth.pin_strength)},
      {"springs", [&](const YAML::Node& map) { read_springs(map, material.springs); }},
      {"ks", into(material.ks)},
      {"untangle", into(cloth.untangle)},
      {"fabric", [](const YAML::Node&) {}},  // read first
      {"self_collision",
       [&](const YAML::Node& value) { read_self_collision(value, cloth.self_collision); }}};
  if (name != nullptr) {
    fields.insert(fields.begin(), {"name", into(*name)});
    cloth.self_collision = SelfCollision::automatic;  // contact of one cloth with another is such
  }
  append(material_fields(cloth), fields);
  const bool is_fabric = names_fabric(node);
  if (is_fabric) start_fabric(node, folder, cloth);
  if (!is_fabric) material.fabric.emplace();  // so that the keys are known
  append(fabric_fields(*material.fabric), fields);
  read_map(node, fields);
  if (!is_fabric) material.fabric.reset();
  read_points(pinned, attached, cloth);
  return cloth;
}

}  // namespace

void read_self_collision(const YAML::Node& node, SelfCollision& self_collision) {
  if (is_word(node, "points")) {
    self_collision = SelfCollision::points;
  } else if (is_word(node, "surface")) {
    self_collision = SelfCollision::surface;
  } else if (is_word(node, "automatic")) {  // as in live values of the node
    self_collision = SelfCollision::automatic;
  } else {
    self_collision = read_switch(node, "true, false, points or surface") ? SelfCollision::automatic
                                                                         : SelfCollision::off;
  }
}

ClothSpec read_cloth(const YAML::Node& node, const std::filesystem::path& folder) {
  return read(node, folder, nullptr);
}

ClothSpec read_cloths(const YAML::Node& node, const std::filesystem::path& folder) {
  std::vector<NamedCloth> cloths;
  read_list(node, [&](const YAML::Node& item) {
    NamedCloth cloth;
    cloth.spec = read(item, folder, &cloth.name);
    cloths.push_back(std::move(cloth));
  });
  ClothSpec joined = join_cloths(cloths);
  if (joined.self_collision != SelfCollision::off) check_apart(*joined.mesh);
  return joined;
}

}  // namespace clothsim
