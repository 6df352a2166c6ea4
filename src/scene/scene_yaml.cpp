#include "clothsim/scene/scene_yaml.h"

#include <optional>
#include <utility>

#include "clothsim/model/checks.h"
#include "clothsim/scene/cloth_yaml.h"
#include "clothsim/scene/colliders_yaml.h"
#include "clothsim/scene/fabric_yaml.h"
#include "clothsim/scene/yaml_values.h"

// Each map of a scene is one list of fields: the keys it may have, and the targets of their values.
// Types are checked here, ranges in validate().

namespace clothsim {
namespace {

namespace fs = std::filesystem;

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

/// Reads a map of live values by name of the cloth.
void read_values_by_cloth(const YAML::Node& map, LiveSpec& live) {
  std::vector<Field> cloths;
  for (LiveSpec::OfCloth& cloth : live.cloths) {
    cloths.push_back(
        {cloth.name, [&cloth](const YAML::Node& values) {
           std::vector<Field> fields = live_fields(cloth.material);
           append({{"friction", into(cloth.friction)}, {"thickness", into(cloth.thickness)}},
                  fields);
           read_map(values, fields);
           validate(cloth.material);  // here, for the name in errors
           validate_contact(cloth.thickness, cloth.friction);
         }});
  }
  read_map(map, cloths);
  live.material = live.cloths.front().material;
  live.friction = live.cloths.front().friction;
  live.thickness = live.cloths.front().thickness;
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
  append({{"friction", into(live.friction)}, {"thickness", into(live.thickness)}}, fields);
  for (LiveSpec::OfCloth& cloth : live.cloths) {  // the same value for each
    std::vector<Field> own = live_fields(cloth.material);
    append({{"friction", into(cloth.friction)}, {"thickness", into(cloth.thickness)}}, own);
    for (std::size_t i = 0; i < fields.size(); ++i) {
      fields[i].read = [first = fields[i].read, next = own[i].read](const YAML::Node& value) {
        first(value);
        next(value);
      };
    }
  }
  append({{"self_collision",
           [&](const YAML::Node& value) { read_self_collision(value, live.self_collision); }},
          {"collider_friction",
           [&](const YAML::Node& map) {
             std::vector<Field> colliders;
             for (auto& [name, friction] : live.collider_friction) {
               colliders.push_back({name, into(friction)});
             }
             read_map(map, colliders);
           }}},
         fields);
  std::optional<YAML::Node> cloths;  // read last: a cloth's own value prevails over that of all
  if (!live.cloths.empty()) {
    fields.push_back({"cloths", [&](const YAML::Node& map) { cloths = map; }});
  }
  read_simulation(node, std::move(fields), live.simulation);
  if (cloths) inside("cloths", [&] { read_values_by_cloth(*cloths, live); });
}

ChangeValues read_change(const YAML::Node& node) {
  // A private copy: simulators of one scene may read it at the same time.
  const YAML::Node copy = YAML::Clone(node);
  return {[copy](LiveSpec& live) { read_live_values(copy, live); }};
}

Scene read_scene(const YAML::Node& root, const SceneSources& sources) {
  Scene scene;
  std::string cloth;                  // the key that has given it
  std::optional<YAML::Node> motions;  // read when the cloth is known
  const auto read_colliders = [&](const YAML::Node& list) {
    read_list(list, [&](const YAML::Node& item) {
      scene.colliders.push_back(read_collider(item, sources));
    });
  };
  const auto read_robots = [&](const YAML::Node& list) {
    read_list(list, [&](const YAML::Node& item) { read_robot(item, sources, scene); });
  };
  const auto read_with = [&](const char* key,
                             ClothSpec (*read)(const YAML::Node&, const fs::path&)) {
    return [&, key, read](const YAML::Node& node) {
      if (!cloth.empty())
        throw InvalidValue({}, "a cloth again", "one of the keys cloth and cloths");
      scene.cloth = read(node, sources.folder);
      cloth = key;
    };
  };
  read_map(root, {{"cloth", read_with("cloth", read_cloth)},
                  {"cloths", read_with("cloths", read_cloths)},
                  {"colliders", read_colliders},
                  {"robots", read_robots},
                  {"simulation",
                   [&spec = scene.simulation](const YAML::Node& node) {
                     read_simulation(node, {{"seed", into(spec.seed)}}, spec);
                   }},
                  {"motions", [&](const YAML::Node& list) { motions = list; }}});
  if (cloth.empty()) throw InvalidValue({"cloth"}, "nothing", "a map");
  if (motions) inside(cloth, [&] { validate(scene.cloth); });
  if (motions) inside("motions", [&] { scene.motions = read_motions(*motions, scene.cloth); });

  validate(scene);
  return scene;
}

}  // namespace clothsim
