#include "clothsim/scene/cloth_mesh_yaml.h"

#include <memory>
#include <string>

#include "clothsim/geometry/cloth_surface.h"
#include "clothsim/model/checks.h"
#include "clothsim/model/resource.h"
#include "clothsim/scene/colliders_yaml.h"
#include "clothsim/scene/scene_yaml.h"
#include "clothsim/scene/yaml_values.h"
#include "clothsim/shapes/mesh_file.h"

namespace clothsim {
namespace {

/// The values of the map.
struct MeshKeys {
  std::string file;
  Vector3 scale{1, 1, 1};  // [m] per unit of the file
  Pose pose;
  Vector3 warp{1, 0, 0};  // in the file's axes
  RestLengths lengths = RestLengths::surface;
  bool is_curved = false;
};

MeshKeys read_keys(const YAML::Node& node) {
  MeshKeys keys;
  const auto read_scale = [&](const YAML::Node& value) {
    keys.scale = value.IsSequence()
                     ? read_vector(value)
                     : Vector3::Constant(read_number(value, "a number or [x, y, z]"));
  };
  const auto read_lengths = [&](const YAML::Node& value) {
    keys.lengths = static_cast<RestLengths>(read_choice(value, {"surface", "uv"}));
  };
  const auto read_rest = [&](const YAML::Node& value) {
    keys.is_curved = read_choice(value, {"flat", "as_is"}) == 1;
  };
  read_map(node, {{"file", into(keys.file)},
                  {"scale", read_scale},
                  {"pose", [&](const YAML::Node& value) { read_pose(value, keys.pose); }},
                  {"warp", [&](const YAML::Node& value) { keys.warp = read_direction(value); }},
                  {"lengths", read_lengths},
                  {"rest", read_rest}});
  check_range("scale", keys.scale.cwiseAbs(), mesh_scale_range);
  if (keys.lengths == RestLengths::uv && node["warp"]) {
    throw InvalidValue({"warp"}, describe(node["warp"]),
                       "none with lengths: uv, which has warp along u");
  }
  if (keys.file.empty()) {
    throw InvalidValue({"file"}, "nothing", "an STL, OBJ, PLY or DAE file");
  }
  return keys;
}

}  // namespace

void read_cloth_mesh(const YAML::Node& node, const std::filesystem::path& folder,
                     ClothSpec& cloth) {
  const MeshKeys keys = read_keys(node);
  inside("pose", [&] { check_range("xyz", keys.pose.position, position_range); });
  inside("file", [&] {
    const MeshTriangles given = read_mesh_triangles(find_resource(keys.file, folder), keys.scale);
    ClothMesh mesh = make_cloth_mesh(given, keys.warp, keys.lengths);
    if (keys.is_curved) mesh.curved.assign(mesh.triangles.size(), 1);
    const Eigen::Matrix3d turn = keys.pose.orientation.toRotationMatrix();
    mesh.positions = (mesh.positions * turn.transpose()).rowwise() + keys.pose.position.transpose();
    cloth.columns = static_cast<int>(mesh.positions.rows());
    cloth.rows = 1;
    cloth.mesh = std::make_shared<const ClothMesh>(std::move(mesh));
  });
}

}  // namespace clothsim
