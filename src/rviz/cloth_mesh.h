#pragma once

#include <clothsim/ClothState.h>
#include <clothsim/ClothTopology.h>

#include <cstdint>
#include <optional>
#include <vector>

#include "clothsim/model/types.h"

// Geometry from messages, without RViz. Messages come from anywhere: they are checked before use.

namespace clothsim_rviz {

/// Throws InvalidValue with the field that is inconsistent with the others.
void check_topology(const clothsim::ClothTopology&);

/// Throws InvalidValue with the field that does not fit a checked topology, or that holds numbers
/// which cannot be drawn.
void check_state(const clothsim::ClothState&, const clothsim::ClothTopology&);

/// Unit normals at the points, flat xyz as `positions` [m]: the mean of the triangles' normals
/// weighted by area; +z where there is none.
void find_normals(const std::vector<float>& positions, const std::vector<std::uint32_t>& triangles,
                  std::vector<float>& normals);

/// Quantities that may colour the cloth, by point.
enum class Quantity {
  stretch,  // of the most stretched spring of the point, by its rest length [-]
  speed,    // [m/s]
  height,   // z [m]
};

/// The N values of checked messages.
std::vector<float> values_of(Quantity, const clothsim::ClothState&, const clothsim::ClothTopology&);

/// The intersection of a ray and a cloth.
struct Hit {
  double distance;          // along the ray, in lengths of its direction
  clothsim::Vector3 place;  // [m]
  std::uint32_t point;      // the nearest point of the cloth
};

/// The first triangle that the ray from `origin` along `direction` hits, from either side. For a
/// cloth without triangles, a rope: the first point within 1 % of its distance from the ray.
std::optional<Hit> first_hit(const clothsim::Vector3& origin, const clothsim::Vector3& direction,
                             const std::vector<float>& positions,
                             const std::vector<std::uint32_t>& triangles);

}  // namespace clothsim_rviz
