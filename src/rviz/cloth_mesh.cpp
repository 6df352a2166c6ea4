#include "cloth_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "clothsim/model/errors.h"
#include "clothsim/ros/tf_frame.h"

namespace clothsim_rviz {
namespace {

using clothsim::InvalidValue;
using clothsim::Vector3;
using Indices = std::vector<std::uint32_t>;

/// Largest distance from the ray of a picked point of a rope, by the distance along the ray: some
/// pixels.
constexpr double rope_aim = 0.01;

void check_size(const char* field, std::size_t size, std::uint64_t expected) {
  if (size == expected) return;
  throw InvalidValue({field}, std::to_string(size) + " numbers", std::to_string(expected));
}

/// Checks indices of points in groups: each must be below `points`.
void check_indices(const char* field, const Indices& indices, std::size_t group,
                   std::uint64_t points) {
  if (indices.size() % group != 0) {
    throw InvalidValue({field}, std::to_string(indices.size()) + " numbers",
                       "groups of " + std::to_string(group));
  }
  const auto largest = std::max_element(indices.begin(), indices.end());
  if (largest != indices.end() && *largest >= points) {
    throw InvalidValue({field}, "point " + std::to_string(*largest),
                       "a point below " + std::to_string(points));
  }
}

void check_numbers(const char* field, const std::vector<float>& numbers) {
  const auto usable = [](float x) { return std::abs(x) <= clothsim_ros::largest_coordinate; };
  const auto wrong = std::find_if_not(numbers.begin(), numbers.end(), usable);  // NaN, too
  if (wrong == numbers.end()) return;
  throw InvalidValue({field, std::to_string(wrong - numbers.begin())}, std::to_string(*wrong),
                     "a number up to " + std::to_string(clothsim_ros::largest_coordinate));
}

std::uint64_t count_points(const clothsim::ClothTopology& topology) {
  return std::uint64_t{topology.columns} * topology.rows;
}

Vector3 at(const std::vector<float>& xyz, std::uint32_t point) {
  const float* p = &xyz[3 * std::size_t{point}];
  return {p[0], p[1], p[2]};
}

float length_between(const std::vector<float>& xyz, std::uint32_t a, std::uint32_t b) {
  const float* p = &xyz[3 * std::size_t{a}];
  const float* q = &xyz[3 * std::size_t{b}];
  const float x = q[0] - p[0], y = q[1] - p[1], z = q[2] - p[2];
  return std::sqrt(x * x + y * y + z * z);
}

/// Raises each point's value to the stretch of its most stretched spring.
void add_stretch(const Indices& springs, const std::vector<float>& rest,
                 const std::vector<float>& positions, std::vector<float>& values) {
  for (std::size_t i = 0; i < springs.size(); i += 2) {
    const std::uint32_t a = springs[i], b = springs[i + 1];
    const float rest_length = length_between(rest, a, b);
    if (!(rest_length > 0)) continue;
    const float stretch = length_between(positions, a, b) / rest_length - 1;
    values[a] = std::max(values[a], stretch);
    values[b] = std::max(values[b], stretch);
  }
}

std::vector<float> stretch_of(const clothsim::ClothState& state,
                              const clothsim::ClothTopology& topology) {
  constexpr float none = -std::numeric_limits<float>::infinity();
  std::vector<float> values(state.positions.size() / 3, none);
  for (const Indices* family : {&topology.structural, &topology.shear, &topology.bending}) {
    add_stretch(*family, topology.rest_positions, state.positions, values);
  }
  std::replace(values.begin(), values.end(), none, 0.0f);  // a point without springs
  return values;
}

/// Distance along the ray to the triangle a, b, c. Moller & Trumbore, Fast, minimum storage
/// ray/triangle intersection, J. Graphics Tools 2(1), 1997.
std::optional<double> meet(const Vector3& origin, const Vector3& direction, const Vector3& a,
                           const Vector3& b, const Vector3& c) {
  const Vector3 ab = b - a, ac = c - a, from_a = origin - a;
  const Vector3 p = direction.cross(ac);
  const double determinant = ab.dot(p);
  if (determinant == 0) return {};  // along the plane, or a triangle without area
  const Vector3 q = from_a.cross(ab);
  const double u = from_a.dot(p) / determinant, v = direction.dot(q) / determinant;
  if (!(u >= 0 && v >= 0 && u + v <= 1)) return {};
  const double distance = ac.dot(q) / determinant;
  return distance > 0 ? std::optional<double>(distance) : std::nullopt;
}

std::optional<Hit> hit_rope(const Vector3& origin, const Vector3& direction,
                            const std::vector<float>& positions) {
  std::optional<Hit> best;
  double best_aside = rope_aim;
  for (std::uint32_t i = 0; 3 * std::size_t{i} < positions.size(); ++i) {
    const Vector3 place = at(positions, i);
    const double along = (place - origin).dot(direction) / direction.squaredNorm();
    const double aside = (place - origin - along * direction).norm() / (along * direction.norm());
    if (!(along > 0 && aside < best_aside)) continue;
    best_aside = aside;
    best = Hit{along, place, i};
  }
  return best;
}

}  // namespace

void check_topology(const clothsim::ClothTopology& topology) {
  const std::uint64_t points = count_points(topology);
  if (points == 0) throw InvalidValue({"columns"}, "no points", "at least one");
  check_size("rest_positions", topology.rest_positions.size(), 3 * points);
  check_size("uv", topology.uv.size(), 2 * points);
  check_indices("triangles", topology.triangles, 3, points);
  check_indices("structural", topology.structural, 2, points);
  check_indices("shear", topology.shear, 2, points);
  check_indices("bending", topology.bending, 2, points);
  check_indices("pinned", topology.pinned, 1, points);
  check_indices("first_points", topology.first_points, 1, points);
  check_numbers("rest_positions", topology.rest_positions);
  check_numbers("uv", topology.uv);
}

void check_state(const clothsim::ClothState& state, const clothsim::ClothTopology& topology) {
  if (state.topology_seq != topology.seq) {
    throw InvalidValue({"topology_seq"}, std::to_string(state.topology_seq),
                       "that of the topology, " + std::to_string(topology.seq));
  }
  const std::uint64_t points = count_points(topology);
  check_size("positions", state.positions.size(), 3 * points);
  check_size("velocities", state.velocities.size(), 3 * points);
  check_indices("held", state.held, 1, points);
  check_numbers("positions", state.positions);
  check_numbers("velocities", state.velocities);
}

void find_normals(const std::vector<float>& positions, const std::vector<std::uint32_t>& triangles,
                  std::vector<float>& normals) {
  normals.assign(positions.size(), 0);
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    // Twice the triangle's area times its normal.
    const float* a = &positions[3 * std::size_t{triangles[i]}];
    const float* b = &positions[3 * std::size_t{triangles[i + 1]}];
    const float* c = &positions[3 * std::size_t{triangles[i + 2]}];
    const float ux = b[0] - a[0], uy = b[1] - a[1], uz = b[2] - a[2];
    const float vx = c[0] - a[0], vy = c[1] - a[1], vz = c[2] - a[2];
    const float x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      float* n = &normals[3 * std::size_t{triangles[i + corner]}];
      n[0] += x;
      n[1] += y;
      n[2] += z;
    }
  }
  for (std::size_t i = 0; i < normals.size(); i += 3) {
    float* n = &normals[i];
    const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (length > 0) {
      for (int axis = 0; axis < 3; ++axis) n[axis] /= length;
    } else {
      n[2] = 1;
    }
  }
}

std::vector<float> values_of(Quantity quantity, const clothsim::ClothState& state,
                             const clothsim::ClothTopology& topology) {
  if (quantity == Quantity::stretch) return stretch_of(state, topology);
  std::vector<float> values(state.positions.size() / 3);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const float* v = &state.velocities[3 * i];
    values[i] = quantity == Quantity::height ? state.positions[3 * i + 2]
                                             : std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  }
  return values;
}

std::optional<Hit> first_hit(const Vector3& origin, const Vector3& direction,
                             const std::vector<float>& positions, const Indices& triangles) {
  if (triangles.empty()) return hit_rope(origin, direction, positions);
  std::optional<Hit> first;
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    const Vector3 a = at(positions, triangles[i]), b = at(positions, triangles[i + 1]),
                  c = at(positions, triangles[i + 2]);
    const std::optional<double> distance = meet(origin, direction, a, b, c);
    if (!distance || (first && *distance >= first->distance)) continue;
    const Vector3 place = origin + *distance * direction;
    const auto nearest =
        std::min_element(&triangles[i], &triangles[i] + 3, [&](std::uint32_t p, std::uint32_t q) {
          return (at(positions, p) - place).norm() < (at(positions, q) - place).norm();
        });
    first = Hit{*distance, place, *nearest};
  }
  return first;
}

}  // namespace clothsim_rviz
