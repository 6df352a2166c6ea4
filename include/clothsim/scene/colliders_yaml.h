#pragma once

#include <yaml-cpp/yaml.h>

#include "clothsim/scene/scene_yaml.h"

namespace clothsim {

/// Range of a collider's friction.
inline constexpr Range friction_range{0, 1e6, ""};

/// Range of the places of colliders and joints.
inline constexpr Range position_range{-1e6, 1e6, "m"};

/// Reads a vector of any length from 1e-6 on as a unit vector. Throws InvalidValue.
Vector3 read_direction(const YAML::Node&);

/// Reads one item of a scene's list `colliders`. Throws InvalidValue.
ColliderSpec read_collider(const YAML::Node&, const SceneSources&);

/// The shape with `padding` [m] all around.
Shape padded(const Shape&, double padding);

/// Reads one item of a scene's list `robots`: adds a collider for each collision of the links it
/// names, called ROBOT/LINK, that follows the link's frame. Unusable collisions are left out, with
/// a line in scene.left_out. Throws InvalidValue for keys, an invalid URDF, an unknown link.
void read_robot(const YAML::Node&, const SceneSources&, Scene&);

}  // namespace clothsim
