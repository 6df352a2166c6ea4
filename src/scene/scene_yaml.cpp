#include "clothsim/scene/scene_yaml.h"

#include <optional>
#include <utility>

#include "clothsim/model/checks.h"
#include "clothsim/scene/cloth_mesh_yaml.h"
#include "clothsim/scene/colliders_yaml.h"
#include "clothsim/scene/fabric_yaml.h"
#include "clothsim/scene/points_yaml.h"
#include "clothsim/scene/yaml_values.h"

// Each map of a scene is one list of fields: the keys it may have, and the targets of their values.
// Types are checked here, ranges in validate().

namespace clothsim {
namespace {

/// true, false, or a name of self_collision_names.
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

void append(std::vector<Field> more, std::vector<Field>& fields) {
  for (Field& field : more) fields.push_back(std::move(field));
}

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
                         "[column, row], or near, within and of, or uv instead");
    }
    if (points.empty()) points = reader.find(place);
  }
  for (const auto& [column, row] : points) {
    pin.column = column;
    pin.row = row;
    pins.push_back(pin);
  }
}

BodyPoints read_attached(const YAML::Node& node, PointReader& points) {
  BodyPoints attached;
  const auto read_points = [&](const YAML::Node& list) {
    read_list(list, [&](const YAML::Node& item) {
      for (const auto& point : points.read(item)) attached.points.push_back(point);
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

/// Throws InvalidValue where a cloth with a mesh has a key of grids.
void check_no_grid(const YAML::Node& node) {
  if (!node.IsMap() || !node["mesh"]) return;
  for (const char* key : {"width", "height", "columns", "rows", "orientation", "origin"}) {
    if (node[key]) {
      throw InvalidValue({key}, describe(node[key]), "none with a mesh, which mesh.pose places");
    }
  }
}

ClothSpec read_cloth(const YAML::Node& node, const SceneSources& sources) {
  check_no_grid(node);
  ClothSpec cloth;
  Material& material = cloth.material;
  const auto read_orientation = [&](const YAML::Node& value) {
    cloth.orientation = static_cast<Orientation>(read_choice(value, {"horizontal", "vertical"}));
  };
  std::optional<YAML::Node> pinned, attached;  // read when the cloth is known
  std::vector<Field> fields = {
      {"mesh", [&](const YAML::Node& map) { read_cloth_mesh(map, sources.folder, cloth); }},
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
  append(material_fields(cloth), fields);
  const bool is_fabric = names_fabric(node);
  if (is_fabric) start_fabric(node, sources.folder, cloth);
  if (!is_fabric) material.fabric.emplace();  // so that the keys are known
  append(fabric_fields(*material.fabric), fields);
  read_map(node, fields);
  if (!is_fabric) material.fabric.reset();
  read_points(pinned, attached, cloth);
  return cloth;
}

/// A count, or auto.
void read_substeps(const YAML::Node& node, std::optional<int>& substeps) {
  if (is_word(node, "auto")) {
    substeps.reset();
  } else {
    substeps = read_int(node, "auto or a whole number");
  }
}

using clothsim::into;
ReadValue into(VelocityVerlet::Parameters::Precision& target) {
  return [&target](const YAML::Node& node) {
    const int choice = read_choice(node, {"double", "single"});
    target = static_cast<VelocityVerlet::Parameters::Precision>(choice);
  };
}

/// Reads the parameters of `method` from a map.
MethodParameters read_method_parameters(const std::string& method, const YAML::Node& node) {
  MethodParameters parameters = default_parameters(method);
  const auto read = [&](auto& chosen) {
    using Chosen = std::decay_t<decltype(chosen)>;
    std::vector<Field> fields;
    if constexpr (!std::is_same_v<Chosen, std::monostate>) {
      Chosen::each(chosen, [&](const char* key, auto& value, const Range&) {
        fields.push_back({key, into(value)});
      });
    }
    if (fields.empty() && node.IsMap() && node.size() > 0) {
      throw InvalidValue({}, "parameters",
                         method == "auto"
                             ? "none with method auto, which chooses a method and its parameters"
                             : "none: method " + method + " has no parameters");
    }
    read_map(node, fields);
  };
  std::visit(read, parameters);
  return parameters;
}

/// Reads a map of `others` and of the live values of a simulation.
void read_simulation(const YAML::Node& node, std::vector<Field> others, SimulationSpec& spec) {
  YAML::Node parameters;  // read once the method is known
  bool has_parameters = false;
  const std::string last_method = spec.method;
  std::vector<Field> fields = {
      {"gravity", into(spec.gravity)},
      {"wind", [&](const YAML::Node& value) { into(spec.wind.emplace())(value); }},
      {"gusts", into(spec.gusts)},
      {"frames_per_second", into(spec.frames_per_second)},
      {"substeps", [&](const YAML::Node& value) { read_substeps(value, spec.substeps); }},
      {"strain_tolerance", into(spec.strain_tolerance)},
      {"tolerance", into(spec.tolerance)},
      {"method", into(spec.method)},
      {"method_parameters", [&](const YAML::Node& value) {
         parameters.reset(value);
         has_parameters = true;
       }}};
  append(std::move(others), fields);
  fields.push_back({"threads", into(spec.threads)});
  read_map(node, fields);
  check_method(spec.method);
  if (has_parameters) {
    inside("method_parameters",
           [&] { spec.method_parameters = read_method_parameters(spec.method, parameters); });
  } else if (spec.method != last_method) {
    spec.method_parameters = {};
  }
}

}  // namespace

Eigen::Quaterniond read_roll_pitch_yaw(const YAML::Node& node) {
  const Vector3 angles = read_vector(node);
  return Eigen::AngleAxisd(angles.z(), Vector3::UnitZ()) *
         Eigen::AngleAxisd(angles.y(), Vector3::UnitY()) *
         Eigen::AngleAxisd(angles.x(), Vector3::UnitX());
}

void read_pose(const YAML::Node& node, Pose& pose) {
  const auto read_rpy = [&](const YAML::Node& angles) {
    pose.orientation = read_roll_pitch_yaw(angles);
  };
  read_map(node, {{"xyz", into(pose.position)}, {"rpy", read_rpy}});
}

void read_springs(const YAML::Node& node, std::array<bool, 3>& springs) {
  std::vector<Field> fields;
  for (size_t i = 0; i < springs.size(); ++i) {
    fields.push_back({spring_family_names[i], into(springs[i])});
  }
  read_map(node, fields);
}

void read_live_values(const YAML::Node& node, LiveSpec& live) {
  std::vector<Field> fields = live_fields(live.material);
  append({{"thickness", into(live.thickness)},
          {"self_collision",
           [&](const YAML::Node& value) { read_self_collision(value, live.self_collision); }},
          {"friction", into(live.friction)},
          {"collider_friction",
           [&](const YAML::Node& map) {
             std::vector<Field> colliders;
             for (auto& [name, friction] : live.collider_friction) {
               colliders.push_back({name, into(friction)});
             }
             read_map(map, colliders);
           }}},
         fields);
  read_simulation(node, std::move(fields), live.simulation);
}

ChangeValues read_change(const YAML::Node& node) {
  // A private copy: simulators of one scene may read it at the same time.
  const YAML::Node copy = YAML::Clone(node);
  return {[copy](LiveSpec& live) { read_live_values(copy, live); }};
}

Scene read_scene(const YAML::Node& root, const SceneSources& sources) {
  Scene scene;
  bool has_cloth = false;
  std::optional<YAML::Node> motions;  // read when the cloth is known
  const auto read_colliders = [&](const YAML::Node& list) {
    read_list(list, [&](const YAML::Node& item) {
      scene.colliders.push_back(read_collider(item, sources));
    });
  };
  const auto read_robots = [&](const YAML::Node& list) {
    read_list(list, [&](const YAML::Node& item) { read_robot(item, sources, scene); });
  };
  read_map(root, {{"cloth",
                   [&](const YAML::Node& node) {
                     scene.cloth = read_cloth(node, sources);
                     has_cloth = true;
                   }},
                  {"colliders", read_colliders},
                  {"robots", read_robots},
                  {"simulation",
                   [&spec = scene.simulation](const YAML::Node& node) {
                     read_simulation(node, {{"seed", into(spec.seed)}}, spec);
                   }},
                  {"motions", [&](const YAML::Node& list) { motions = list; }}});
  if (!has_cloth) throw InvalidValue({"cloth"}, "nothing", "a map");
  if (motions) inside("cloth", [&] { validate(scene.cloth); });
  if (motions) inside("motions", [&] { scene.motions = read_motions(*motions, scene.cloth); });

  validate(scene);
  return scene;
}

}  // namespace clothsim
