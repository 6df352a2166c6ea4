#pragma once

#include <sstream>
#include <string>
#include <vector>

#include "clothsim/model/checks.h"
#include "clothsim/model/errors.h"
#include "clothsim/scene/scene_yaml.h"
#include "clothsim/shapes/mesh_file.h"

namespace clothsim {

/// A scene with every kind of entry.
inline constexpr const char* good_scene = R"(
cloth:
  width: 1.0
  height: 2.0
  columns: 5
  rows: 4
  orientation: horizontal
  origin: [0, 0, 1]
  pinned: [[0, 0], {point: [4, 3], frame: hand}]
  springs: {structural: true, shear: true, bending: false}
  ks: 5000
  density: 150
  damping: 5.4
  strain_limit: 0.1
  thickness: 0.0095
  self_collision: false
colliders:
  - {name: ball, shape: sphere, center: [0.5, 0.5, 0.2], radius: 0.2, friction: 0.3, frame: ball}
  - {name: ground, shape: plane, point: [0, 0, 0], normal: [0, 0, 1], friction: 0.5, two_sided: false}
simulation:
  gravity: [0, 0, -9.8]
  frames_per_second: 90
  substeps: auto
  method: auto
  seed: 1
  threads: 2
)";

/// Reads `text`; the message of the refusal, or "accepted".
inline std::string refusal(const std::string& text) {
  try {
    read_scene(YAML::Load(text));
  } catch (const InvalidValue& error) {
    return error.what();
  }
  return "accepted";
}

/// The good scene after `assignments`, such as "cloth.ks=500".
inline Scene read_changed(const std::vector<std::string>& assignments) {
  YAML::Node root = YAML::Load(good_scene);
  override_values(root, assignments);
  return read_scene(root);
}

/// A whole scene as one text, to compare scenes.
inline std::string print(const Scene& scene) {
  std::ostringstream out;
  out.precision(12);
  const auto print_vector = [&](const Vector3& v) {
    out << '[' << v.x() << ' ' << v.y() << ' ' << v.z() << "] ";
  };
  const ClothSpec& cloth = scene.cloth;
  out << cloth.width << ' ' << cloth.height << ' ' << cloth.columns << ' ' << cloth.rows << ' '
      << static_cast<int>(cloth.orientation) << ' ' << cloth.thickness << ' '
      << self_collision_names[static_cast<std::size_t>(cloth.self_collision)] << ' '
      << cloth.friction << ' ';
  print_vector(cloth.origin);
  for (const Pin& pin : cloth.pinned) {
    out << "pin " << pin.column << ' ' << pin.row << ' ' << pin.frame << ' ';
  }
  for (const ClothPart& part : cloth.parts) out << part.name << ' ' << part.friction << ' ';
  const Material& material = cloth.material;
  out << material.ks << ' ' << material.density << ' ' << material.damping << ' '
      << material.strain_limit.value_or(-1) << ' ';
  for (const bool on : material.springs) out << on;
  if (material.fabric) {
    const Fabric& fabric = *material.fabric;
    out << " fabric " << fabric.stretch_stiffness[0] << ' ' << fabric.stretch_stiffness[1] << ' '
        << fabric.shear_stiffness << ' ' << fabric.bending_stiffness[0] << ' '
        << fabric.bending_stiffness[1] << ' ' << fabric.internal_damping[0] << ' '
        << fabric.internal_damping[1] << ' ' << fabric.poisson;
  }
  if (material.drag != Material().drag) {
    out << " drag " << material.drag[0] << ' ' << material.drag[1];
  }
  for (const ColliderSpec& collider : scene.colliders) {
    out << " collider " << collider.name << ' ' << collider.friction << ' ' << collider.frame
        << ' ';
    print_vector(collider.pose.position);
    const Vector3 normal = collider.pose.orientation * Vector3::UnitZ();
    print_vector((normal * 1e12).array().round() * 1e-12 + 0.0);  // without rounding errors
    if (const auto* sphere = std::get_if<Sphere>(&collider.shape)) out << sphere->radius;
    if (const auto* plane = std::get_if<Plane>(&collider.shape)) out << plane->two_sided;
    if (const auto* capsule = std::get_if<Capsule>(&collider.shape)) {
      out << capsule->length << ' ' << capsule->radius;
    }
    if (const auto* cylinder = std::get_if<Cylinder>(&collider.shape)) {
      out << cylinder->length << ' ' << cylinder->radius;
    }
    if (const auto& body = collider.body) {
      out << " mass " << body->mass << ' ' << body->damping;
      print_vector(body->velocity);
      print_vector(body->angular_velocity);
      print_vector(body->center_of_mass.value_or(Vector3::Zero()));
      if (body->inertia) out << *body->inertia;
    }
    if (const auto* mesh = std::get_if<MeshShape>(&collider.shape)) {
      out << mesh->file->uri << ' ' << mesh->padding << ' ';
      print_vector(mesh->file->scale);
    }
    if (!collider.offset.position.isZero(0) || !collider.offset.orientation.vec().isZero(0)) {
      print_vector(collider.offset.position);
      print_vector(collider.offset.orientation.vec());
    }
    if (const auto* box = std::get_if<Cuboid>(&collider.shape)) {
      print_vector(box->size);
      print_vector(collider.pose.orientation * Vector3::UnitX());
    }
  }
  out << ' ';
  print_vector(scene.simulation.gravity);
  out << scene.simulation.frames_per_second << ' ' << scene.simulation.substeps.value_or(0) << ' '
      << scene.simulation.strain_tolerance << ' ' << scene.simulation.tolerance << ' '
      << scene.simulation.method << ' ' << scene.simulation.seed << ' ' << scene.simulation.threads;
  std::visit(
      [&](const auto& parameters) {
        using Parameters = std::decay_t<decltype(parameters)>;
        if constexpr (!std::is_same_v<Parameters, std::monostate>) {
          Parameters::each(parameters, [&](const char* key, const auto& value, const Range&) {
            out << ' ' << key << ' ' << value;
          });
        }
      },
      scene.simulation.method_parameters);
  return out.str();
}

}  // namespace clothsim
