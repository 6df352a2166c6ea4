#include "clothsim/scene/fixed_values.h"

#include <filesystem>
#include <functional>
#include <string_view>
#include <type_traits>

#include "clothsim/model/checks.h"
#include "clothsim/shapes/mesh_file.h"

namespace clothsim {
namespace {

std::string text(double value) { return to_text(value); }
std::string text(const Vector3& v) {
  return '[' + join({text(v[0]), text(v[1]), text(v[2])}) + ']';
}
std::string text(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.orientation;
  return text(pose.position) + " [" + join({text(q.x()), text(q.y()), text(q.z()), text(q.w())}) +
         ']';
}

// Sizes of the shapes.
std::string text(const Sphere& sphere) { return text(sphere.radius); }
std::string text(const Plane& plane) { return plane.two_sided ? "two_sided" : "one-sided"; }
std::string text(const Capsule& c) { return join({text(c.length), text(c.radius)}); }
std::string text(const Cuboid& box) { return text(box.size); }
std::string text(const Cylinder& c) { return join({text(c.length), text(c.radius)}); }
std::string text(const MeshShape& mesh) {
  return join({std::filesystem::path(mesh.file->uri).filename().string(), text(mesh.file->scale),
               text(mesh.padding), mesh.file->solid.is_sheet() ? "sheet" : "solid"});
}

/// The values that each of several cloths has of its own; a program knows those of the first.
std::string text(const Material& material) {
  const Fabric& fabric = *material.fabric;
  const auto& [warp, weft] = fabric.stretch_stiffness;
  const auto& [bend_warp, bend_weft] = fabric.bending_stiffness;
  std::string springs;
  for (const bool on : material.springs) springs += on ? '1' : '0';
  return join({text(material.density), text(warp), text(weft), text(fabric.shear_stiffness),
               text(bend_warp), text(bend_weft), text(fabric.poisson),
               text(fabric.internal_damping[0]), text(fabric.internal_damping[1]),
               text(material.damping), text(material.drag[0]), text(material.drag[1]),
               material.strain_limit ? text(*material.strain_limit) : "off", springs});
}

/// Hash of all numbers of a mesh.
std::size_t hash_of(const ClothMesh& mesh) {
  const auto bytes = [](const auto& list) {
    return std::string_view(reinterpret_cast<const char*>(list.data()),
                            static_cast<std::size_t>(list.size()) * sizeof(*list.data()));
  };
  std::size_t hash = 0;
  for (const std::string_view part : {bytes(mesh.positions), bytes(mesh.triangles),
                                      bytes(mesh.flat), bytes(mesh.uv), bytes(mesh.curved)}) {
    hash = 31 * hash + std::hash<std::string_view>()(part);
  }
  return hash;
}

/// Lines of keys and values.
class KeyedLines {
 public:
  void add(const std::string& key, const std::string& value) { text_ += key + ": " + value + '\n'; }
  const std::string& all() const { return text_; }

 private:
  std::string text_;
};

void add(const ClothSpec& cloth, KeyedLines& lines) {
  if (cloth.mesh) {
    lines.add("cloth.mesh", std::to_string(cloth.mesh->triangles.size()) + " triangles of " +
                                std::to_string(cloth.columns) + " points, " +
                                std::to_string(hash_of(*cloth.mesh)));
  }
  for (std::size_t i = 0; i < cloth.parts.size(); ++i) {
    const ClothPart& part = cloth.parts[i];
    const std::string own =
        i == 0 ? ""
               : ' ' + text(part.material) + ' ' + text(part.friction) + ' ' + text(part.thickness);
    lines.add("cloths", part.name + ' ' + grid_point_text(part.columns, part.rows) + own);
  }
  lines.add("cloth.columns", std::to_string(cloth.columns));
  lines.add("cloth.rows", std::to_string(cloth.rows));
  lines.add("cloth.width", text(cloth.width));
  lines.add("cloth.height", text(cloth.height));
  lines.add("cloth.orientation",
            cloth.orientation == Orientation::horizontal ? "horizontal" : "vertical");
  lines.add("cloth.origin", text(cloth.origin));
  lines.add("cloth", cloth.material.fabric ? "a fabric" : "springs");
  std::string pins;
  for (const Pin& pin : cloth.pinned) {
    const std::optional<double> strength = pin.strength ? pin.strength : cloth.pin_strength;
    pins += '[' +
            join({std::to_string(pin.column), std::to_string(pin.row), pin.frame,
                  strength ? text(*strength) : "usual strength"}) +
            ']';
  }
  lines.add("cloth.pinned", pins);
  std::string attached;
  for (const BodyPoints& on_body : cloth.attached) {
    attached += on_body.body;
    for (const auto& [column, row] : on_body.points) attached += grid_point_text(column, row);
    if (on_body.tear_force) attached += " up to " + text(*on_body.tear_force);
  }
  lines.add("cloth.attached", attached);
}

void add(const BodySpec& body, const std::string& key, KeyedLines& lines) {
  lines.add(key + ".mass", text(body.mass));
  lines.add(key + ".center_of_mass", body.center_of_mass ? text(*body.center_of_mass) : "even");
  if (body.inertia) {
    const Matrix3& i = *body.inertia;
    lines.add(key + ".inertia", join({text(i(0, 0)), text(i(0, 1)), text(i(0, 2)), text(i(1, 1)),
                                      text(i(1, 2)), text(i(2, 2))}));
  }
  lines.add(key + ".damping", text(body.damping));
  if (body.joint) {
    const Joint& joint = *body.joint;
    lines.add(key + ".joint",
              join({joint.kind == Joint::Kind::slider ? "slider" : "hinge", text(joint.axis),
                    text(joint.point), text(joint.lower), text(joint.upper)}));
  }
  lines.add(key + ".velocity", text(body.velocity) + ' ' + text(body.angular_velocity));
}

void add(const ColliderSpec& collider, KeyedLines& lines) {
  const auto shape = [](const auto& s) {
    return std::string(std::decay_t<decltype(s)>::name) + ' ' + text(s);
  };
  const std::string key = "collider " + collider.name;
  lines.add(key, std::visit(shape, collider.shape));
  lines.add(key + ".pose", text(collider.pose) + " in its frame at " + text(collider.offset));
  lines.add(key + ".frame", collider.frame);
  lines.add(key + ".part_of", collider.part_of);
  lines.add(key + ".enabled", collider.enabled ? "true" : "false");
  if (collider.body) add(*collider.body, key, lines);
}

void add(const SimulationSpec& simulation, KeyedLines& lines) {
  lines.add("simulation.strain_tolerance", text(simulation.strain_tolerance));
  lines.add("simulation.tolerance", text(simulation.tolerance));
  lines.add("simulation.seed", std::to_string(simulation.seed));
  std::visit(
      [&](const auto& parameters) {
        using Parameters = std::decay_t<decltype(parameters)>;
        if constexpr (!std::is_same_v<Parameters, std::monostate>) {
          Parameters::each(parameters, [&](const char* key, const auto& value, const Range&) {
            lines.add("simulation.method_parameters of " + simulation.method + '.' + key,
                      text(static_cast<double>(value)));
          });
        }
      },
      simulation.method_parameters);
}

}  // namespace

std::string fixed_values(const Scene& scene) {
  KeyedLines lines;
  add(scene.cloth, lines);
  for (const ColliderSpec& collider : scene.colliders) add(collider, lines);
  add(scene.simulation, lines);
  return lines.all();
}

}  // namespace clothsim
