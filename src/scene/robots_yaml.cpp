// Robots of a scene: colliders that follow the links of a URDF.

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>
#include <utility>

#include "clothsim/model/checks.h"
#include "clothsim/model/resource.h"
#include "clothsim/scene/colliders_yaml.h"
#include "clothsim/scene/robot_models.h"
#include "clothsim/scene/urdf.h"
#include "clothsim/scene/urdf_bodies.h"
#include "clothsim/scene/yaml_values.h"
#include "clothsim/shapes/mesh_file.h"

namespace clothsim {
namespace {

/// A robot as in a scene.
struct Robot {
  std::string description;  // name of a parameter
  std::string file;
  std::string name;  // empty: the URDF's
  std::string prefix;
  std::vector<std::string> links;
  bool has_all = true;
  double friction = 0.6;
  double padding = 0;
  Pose pose;                // of its root, until frames are known
  bool has_bodies = false;  // its links are rigid bodies

  Urdf urdf;
  std::filesystem::path folder;  // for relative paths of meshes
};

/// Range of the padding of each side, far beyond a robot's needs.
constexpr Range robot_padding_range{0, 1, "m"};

void read_links(const YAML::Node& node, Robot& robot) {
  if (is_word(node, "all")) return;
  if (!node.IsSequence()) throw InvalidValue({}, describe(node), "all or a list of links");
  robot.has_all = false;
  read_list(node, [&](const YAML::Node& item) { robot.links.push_back(read_text(item)); });
}

std::string text_of(const std::filesystem::path& path) {
  std::error_code error;
  std::ifstream file(path, std::ios::binary);
  if (!std::filesystem::is_regular_file(path, error) || !file) {
    throw InvalidValue({}, '"' + shortened(path.string(), 200) + "\", which cannot be read",
                       "a URDF or SDF file");
  }
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

void load(const SceneSources& sources, Robot& robot) {
  if (robot.description.empty() == robot.file.empty()) {
    throw InvalidValue({"description"}, robot.file.empty() ? "nothing" : "a file, too",
                       "a parameter with a URDF, or a file");
  }
  if (!robot.file.empty()) {
    inside("file", [&] {
      const std::filesystem::path path = find_resource(robot.file, sources.folder);
      robot.folder = path.parent_path();
      robot.urdf = read_urdf(text_of(path));
    });
    return;
  }
  inside("description", [&] {
    if (!sources.description) {
      throw InvalidValue({}, "a parameter, outside of ROS", "a file instead: the key file");
    }
    robot.folder = sources.folder;
    robot.urdf = read_urdf(sources.description(robot.description));
  });
}

void check_links(const Robot& robot) {
  std::vector<std::string> known;
  for (const Urdf::Link& link : robot.urdf.links) known.push_back(link.name);
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    if (std::find(known.begin(), known.end(), robot.links[i]) != known.end()) continue;
    throw InvalidValue({"links", std::to_string(i)}, '"' + shortened(robot.links[i], 100) + '"',
                       "one of " + shortened(join(known), 1000));
  }
}

/// The shapes of a geometry; a file may give several.
template <class S>
std::vector<Shape> shapes_of(const S& shape, const Robot&) {
  return {shape};
}
std::vector<Shape> shapes_of(const Urdf::Mesh& mesh, const Robot& robot) {
  check_range("scale", mesh.scale.cwiseAbs(), mesh_scale_range);
  const std::filesystem::path path = find_resource(mesh.file, robot.folder);
  std::vector<Shape> shapes;
  for (const auto& file : read_mesh_files(path, uri_of(mesh.file, path), mesh.scale)) {
    shapes.push_back(MeshShape{file});
  }
  return shapes;
}

/// The colliders of one collision of a link. Throws InvalidValue for an unusable collision.
std::vector<ColliderSpec> colliders_of(const Urdf::Link& link, const Urdf::Collision& collision,
                                       const Robot& robot) {
  if (!collision.fault.empty()) throw InvalidValue({}, collision.fault, "a collision geometry");
  std::vector<ColliderSpec> colliders;
  const auto shapes =
      std::visit([&](const auto& s) { return shapes_of(s, robot); }, collision.geometry);
  for (const Shape& shape : shapes) {
    ColliderSpec collider;
    collider.frame = robot.prefix + link.name;
    collider.pose = robot.pose * link.pose;
    collider.offset = collision.origin;
    collider.offset.orientation.normalize();
    collider.friction = robot.friction;
    collider.shape = padded(shape, robot.padding);
    collider.name = link.name;
    validate(collider);
    colliders.push_back(collider);
  }
  return colliders;
}

const std::string& name_of(const Robot& robot) {
  return robot.name.empty() ? robot.urdf.name : robot.name;
}

/// `names`: the names of all colliders so far.
void add_link(const Urdf::Link& link, const Robot& robot, std::set<std::string>& names,
              Scene& scene) {
  const std::string name = name_of(robot) + '/' + robot.prefix + link.name;
  int number = 0;
  const auto next_name = [&] {  // the first one has the link's own name
    const std::string own = ++number == 1 ? name : name + ':' + std::to_string(number);
    if (names.insert(own).second) return own;
    throw InvalidValue({"name"}, '"' + shortened(own, 100) + "\" again",
                       "another name or prefix than that of other robots");
  };
  for (const Urdf::Collision& collision : link.collisions) {
    std::vector<ColliderSpec> colliders;
    try {
      colliders = colliders_of(link, collision, robot);
    } catch (const InvalidValue& error) {
      scene.left_out.push_back(error.inside(next_name()).what());
    }
    for (ColliderSpec& collider : colliders) {
      collider.name = next_name();
      scene.colliders.push_back(std::move(collider));
    }
  }
}

}  // namespace

namespace {

/// Reads an item of the list, with its URDF.
Robot read_entry(const YAML::Node& node, const SceneSources& sources) {
  Robot robot;
  read_map(node, {{"description", into(robot.description)},
                  {"file", into(robot.file)},
                  {"name", into(robot.name)},
                  {"links", [&](const YAML::Node& links) { read_links(links, robot); }},
                  {"friction", into(robot.friction)},
                  {"padding", into(robot.padding)},
                  {"prefix",
                   [&](const YAML::Node& text) {
                     if (!is_word(text, "")) robot.prefix = read_text(text);
                   }},
                  {"bodies", into(robot.has_bodies)},
                  {"pose", [&](const YAML::Node& pose) { read_pose(pose, robot.pose); }}});
  check_range("padding", robot.padding, robot_padding_range);
  ColliderSpec any;  // of its links: values that are invalid for all of them are refused
  any.name = "robot";
  any.friction = robot.friction;
  any.pose = robot.pose;
  validate(any);
  load(sources, robot);
  check_links(robot);
  return robot;
}

}  // namespace

void read_robot(const YAML::Node& node, const SceneSources& sources, Scene& scene) {
  const Robot robot = read_entry(node, sources);
  const std::size_t first = scene.colliders.size();
  std::set<std::string> names;
  for (const ColliderSpec& collider : scene.colliders) names.insert(collider.name);
  bool has_collisions = false;
  std::vector<std::pair<const Urdf::Link*, std::size_t>> links;  // by collider
  for (const Urdf::Link& link : robot.urdf.links) {
    const bool is_named =
        std::find(robot.links.begin(), robot.links.end(), link.name) != robot.links.end();
    if (!robot.has_all && !is_named) continue;
    has_collisions = has_collisions || !link.collisions.empty();
    add_link(link, robot, names, scene);
    while (first + links.size() < scene.colliders.size()) {
      links.emplace_back(&link, first + links.size());
    }
  }
  if (robot.has_bodies) {
    std::vector<LinkCollider> all;
    for (const auto& [link, index] : links) all.push_back({link, &scene.colliders[index]});
    make_bodies(robot.urdf, robot.pose, all);
  }
  if (has_collisions) return;
  scene.left_out.push_back(InvalidValue({name_of(robot)}, "links without <collision>",
                                        "some: nothing of it touches the cloth")
                               .what());
}

std::vector<RobotModel> read_robot_models(const YAML::Node& scene, const SceneSources& sources) {
  std::vector<RobotModel> models;
  if (!scene.IsMap() || !scene["robots"].IsDefined()) return models;
  inside("robots", [&] {
    for (std::size_t i = 0; i < scene["robots"].size(); ++i) {
      inside(std::to_string(i), [&] {
        const Robot robot = read_entry(scene["robots"][i], sources);
        if (robot.has_bodies) return;  // nobody drives its joints
        models.push_back({name_of(robot), robot.prefix, robot.pose, Kinematics(robot.urdf)});
      });
    }
  });
  return models;
}

}  // namespace clothsim
