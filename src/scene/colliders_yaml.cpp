#include "clothsim/scene/colliders_yaml.h"

#include <Eigen/Eigenvalues>
#include <functional>

#include "clothsim/model/resource.h"
#include "clothsim/scene/scene_yaml.h"
#include "clothsim/scene/yaml_values.h"
#include "clothsim/shapes/mass_properties.h"
#include "clothsim/shapes/mesh_file.h"

namespace clothsim {
namespace {

constexpr Range size_range{1e-6, 1e6, "m"};
constexpr Range padding_range{0, 1e3, "m"};
constexpr Range sheet_range{1e-6, 1e3, "m"};
constexpr Range position_range{-1e6, 1e6, "m"};

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
            const Vector3 z = read_vector(node);
            if (!(z.stableNorm() >= written_rounding)) {
              throw InvalidValue({}, describe(node), "a direction, of a length of at least 1e-06");
            }
            pose.orientation =
                Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), z.stableNormalized());
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

/// Moments of inertia [kg m^2]: [xx, yy, zz], or [xx, xy, xz, yy, yz, zz] as in a URDF.
Matrix3 read_inertia(const YAML::Node& node) {
  const bool is_list = node.IsSequence() && (node.size() == 3 || node.size() == 6);
  if (!is_list) {
    throw InvalidValue({}, describe(node), "[xx, yy, zz] or [xx, xy, xz, yy, yz, zz]");
  }
  if (node.size() == 3) return read_vector(node).asDiagonal();
  std::vector<double> m;
  read_list(node, [&](const YAML::Node& item) { m.push_back(read_number(item)); });
  Matrix3 inertia;
  inertia << m[0], m[1], m[2], m[1], m[3], m[4], m[2], m[4], m[5];
  return inertia;
}

/// The further keys of a collider with a mass.
std::vector<Field> fields_of(BodySpec& body) {
  return {
      {"inertia", [&](const YAML::Node& node) { body.inertia = read_inertia(node); }},
      {"center_of_mass", [&](const YAML::Node& node) { body.center_of_mass = read_vector(node); }},
      {"damping", into(body.damping)},
      {"velocity", into(body.velocity)},
      {"angular_velocity", into(body.angular_velocity)}};
}

/// A solid's principal moments are positive, and none is larger than the sum of the others.
void check_inertia(const Matrix3& inertia) {
  const Vector3 moments = Eigen::SelfAdjointEigenSolver<Matrix3>(inertia).eigenvalues();
  const bool is_solid = moments.allFinite() && moments[0] >= inertia_range.min &&
                        moments[2] <= inertia_range.max &&
                        moments[2] <= (1 + written_rounding) * (moments[0] + moments[1]);
  if (is_solid) return;
  throw InvalidValue({"inertia"},
                     "the principal moments " + to_text(moments[0]) + ", " + to_text(moments[1]) +
                         " and " + to_text(moments[2]),
                     "those of a solid: each above " + to_text(inertia_range.min) +
                         " kg m^2 and at most the sum of the other two");
}

void check_body(const ColliderSpec& collider) {
  const BodySpec& body = *collider.body;
  check_range("mass", body.mass, body_mass_range);
  if (std::holds_alternative<Plane>(collider.shape)) {
    throw InvalidValue({"mass"}, "that of a plane", "a solid");
  }
  const std::optional<MassProperties> even = mass_properties(collider.shape);
  if (body.center_of_mass) {
    check_range("center_of_mass", *body.center_of_mass, position_range);
  } else if (!even) {
    throw InvalidValue({"center_of_mass"}, "nothing", "one, as a sheet has no volume");
  }
  if (!even && !body.inertia) {
    throw InvalidValue({"inertia"}, "nothing", "one, as a sheet has no volume");
  }
  check_inertia(body.inertia.value_or(body.mass * even.value_or(MassProperties()).inertia));
  check_range("damping", body.damping, body_damping_range);
  check_range("velocity", body.velocity, velocity_range);
  check_range("angular_velocity", body.angular_velocity, angular_velocity_range);
  if (!collider.frame.empty()) {
    throw InvalidValue({"frame"}, collider.frame, "none, as the collider has a mass");
  }
}

template <class... S>
std::vector<Shape> one_of_each(const std::variant<S...>&) {
  return {S()...};
}

}  // namespace

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
      {"pose", [&](const YAML::Node& pose) { read_pose(pose, collider.offset); }},
      {"mass", [&](const YAML::Node& mass) { into(collider.body->mass)(mass); }}};
  const std::vector<Key> keys = keys_of(collider);
  for (const Key& key : keys) fields.push_back({key.name, key.read});
  if (node["mass"]) {
    collider.body.emplace();
    const std::vector<Field> of_body = fields_of(*collider.body);
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
}

}  // namespace clothsim
