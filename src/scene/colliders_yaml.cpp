#include "clothsim/scene/colliders_yaml.h"

#include <functional>

#include "clothsim/model/resource.h"
#include "clothsim/scene/bodies_yaml.h"
#include "clothsim/scene/scene_yaml.h"
#include "clothsim/scene/yaml_values.h"
#include "clothsim/shapes/mesh_file.h"

namespace clothsim {
namespace {

constexpr Range size_range{1e-6, 1e6, "m"};
constexpr Range padding_range{0, 1e3, "m"};
constexpr Range sheet_range{1e-6, 1e3, "m"};

/// A key of a shape: the reader of its value, and functions that use the value.
struct Key {
  const char* name;
  ReadValue read;
  std::function<void()> check = [] {};
  std::function<void(double)> grow = [](double) {};                             // on all sides [m]
  std::function<void(const std::filesystem::path&)> load = [](const auto&) {};  // after all keys
};

Key place(Pose& pose, const char* name = "center") {
  return {name, into(pose.position),
          [=, &pose] { check_range(name, pose.position, position_range); }};
}

/// The direction of +z of the shape's own frame.
Key direction(const char* name, Pose& pose) {
  return {name, [&pose](const YAML::Node& node) {
            pose.orientation =
                Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), read_direction(node));
          }};
}

Key turn(Pose& pose) {
  return {"rpy", [&](const YAML::Node& node) { pose.orientation = read_roll_pitch_yaw(node); }};
}

void add(double by, double& length) { length += by; }
void add(double by, Vector3& lengths) { lengths.array() += by; }

/// Lengths that grow by the padding at each of `ends` ends.
template <class T>
Key lengths(const char* name, T& value, int ends, const Range& range = size_range) {
  return {name, into(value), [=, &value] { check_range(name, value, range); },
          [=, &value](double by) { add(ends * by, value); }};
}

// The keys of a shape, apart from those that all shapes have.

std::vector<Key> keys_of(Sphere& sphere, Pose& pose) {
  return {place(pose), lengths("radius", sphere.radius, 1)};
}

std::vector<Key> keys_of(Plane& plane, Pose& pose) {
  return {place(pose, "point"), direction("normal", pose), {"two_sided", into(plane.two_sided)}};
}

std::vector<Key> keys_of(Capsule& c, Pose& pose) {
  return {place(pose), direction("axis", pose), lengths("length", c.length, 0),
          lengths("radius", c.radius, 1)};
}

std::vector<Key> keys_of(Cuboid& box, Pose& pose) {
  return {place(pose), lengths("size", box.size, 2), turn(pose)};
}

std::vector<Key> keys_of(Cylinder& c, Pose& pose) {
  return {place(pose), direction("axis", pose), lengths("length", c.length, 2),
          lengths("radius", c.radius, 1)};
}

std::vector<Key> keys_of(MeshShape& mesh, Pose& pose) {
  const auto name = std::make_shared<std::string>();
  const auto scale = std::make_shared<Vector3>(1, 1, 1);  // [m] per unit of the file
  const auto thickness = std::make_shared<std::optional<double>>();
  const auto require = [](bool is_there) {
    if (!is_there) throw InvalidValue({"file"}, "nothing", "an STL, OBJ or DAE file");
  };
  Key file{"file", into(*name), [=, &mesh] { require(mesh.file != nullptr); }};
  file.load = [=, &mesh](const std::filesystem::path& folder) {
    check_range("scale", scale->cwiseAbs(), mesh_scale_range);
    if (*thickness) check_range("thickness", **thickness, sheet_range);
    require(!name->empty());
    inside("file", [&] {
      const std::filesystem::path path = find_resource(*name, folder);
      mesh.file = read_mesh_file(path, uri_of(*name, path), *scale,
                                 *thickness ? Bounds::sheet : Bounds::solid);
    });
    mesh.padding += thickness->value_or(0) / 2;
  };
  const auto read_scale = [=](const YAML::Node& node) {
    *scale = node.IsSequence() ? read_vector(node)
                               : Vector3::Constant(read_number(node, "a number or [x, y, z]"));
  };
  const Key padding = lengths("padding", mesh.padding, 1, padding_range);
  const auto read_thickness = [=](const YAML::Node& node) { into(thickness->emplace())(node); };
  return {
      place(pose), padding, turn(pose), file, {"scale", read_scale}, {"thickness", read_thickness}};
}

std::vector<Key> keys_of(ColliderSpec& collider) {
  return std::visit([&](auto& shape) { return keys_of(shape, collider.pose); }, collider.shape);
}

void check_part(const ColliderSpec& collider) {
  if (collider.body) throw InvalidValue({"part_of"}, collider.part_of, "none, or no mass");
  if (!collider.frame.empty()) {
    throw InvalidValue({"frame"}, collider.frame, "none, as the collider moves with a body");
  }
  if (std::holds_alternative<Plane>(collider.shape)) {
    throw InvalidValue({"part_of"}, "a plane", "a solid");
  }
}

template <class... S>
std::vector<Shape> one_of_each(const std::variant<S...>&) {
  return {S()...};
}

}  // namespace

Vector3 read_direction(const YAML::Node& node) {
  const Vector3 v = read_vector(node);
  if (!(v.stableNorm() >= written_rounding)) {
    throw InvalidValue({}, describe(node), "a direction, of a length of at least 1e-06");
  }
  return v.stableNormalized();
}

ColliderSpec read_collider(const YAML::Node& node, const SceneSources& sources) {
  const std::vector<Shape> kinds = one_of_each(Shape());
  std::vector<std::string> names;
  for (const Shape& kind : kinds) {
    names.emplace_back(std::visit([](const auto& s) { return s.name; }, kind));
  }
  if (!node.IsMap()) throw InvalidValue({}, describe(node), "a map");

  // The shape decides which keys are allowed.
  std::size_t kind = 0;
  inside("shape", [&] { kind = static_cast<std::size_t>(read_choice(node["shape"], names)); });

  ColliderSpec collider;
  collider.name = names[kind];
  collider.shape = kinds[kind];
  std::vector<Field> fields = {
      {"name", into(collider.name)},
      {"shape", [](const YAML::Node&) {}},
      {"friction", into(collider.friction)},
      {"frame", into(collider.frame)},
      {"enabled", into(collider.enabled)},
      {"part_of", into(collider.part_of)},
      {"pose", [&](const YAML::Node& pose) { read_pose(pose, collider.offset); }},
      {"mass", [&](const YAML::Node& mass) { into(collider.body->mass)(mass); }}};
  const std::vector<Key> keys = keys_of(collider);
  for (const Key& key : keys) fields.push_back({key.name, key.read});
  if (node["mass"]) {
    collider.body.emplace();
    const std::vector<Field> of_body = body_fields(*collider.body);
    fields.insert(fields.end(), of_body.begin(), of_body.end());
  }
  read_map(node, fields);
  for (const Key& key : keys) key.load(sources.folder);
  return collider;
}

Shape padded(const Shape& shape, double padding) {
  ColliderSpec collider;
  collider.shape = shape;
  for (const Key& key : keys_of(collider)) key.grow(padding);
  return collider.shape;
}

void validate(const ColliderSpec& collider) {
  if (collider.name.empty()) throw InvalidValue({"name"}, "an empty name", "a name");
  ColliderSpec copy = collider;  // keys_of() needs one that is not const
  for (const Key& key : keys_of(copy)) key.check();
  check_orientation(collider.pose.orientation);
  inside("pose", [&] {
    check_range("xyz", collider.offset.position, position_range);
    check_orientation(collider.offset.orientation);
  });
  check_range("friction", collider.friction, friction_range);
  check_frame(collider.frame);
  if (collider.body) check_body(collider);
  if (!collider.part_of.empty()) check_part(collider);
}

}  // namespace clothsim
