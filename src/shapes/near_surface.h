// Signed distance and normal of one point, without branches but for meshes: what scalar code calls
// and vector loops inline. The point (x, y, z) and the normal are in the shape's own frame.
#pragma once

#include <cmath>

#include "clothsim/shapes/mesh_file.h"
#include "clothsim/shapes/shape.h"

namespace clothsim {

/// As Distance.
struct NearSurface {
  double value;
  double x;
  double y;
  double z;
};

/// Length (x, y, z) - inset, and its direction; `otherwise` is that of no length.
[[gnu::always_inline]] inline NearSurface about_core(double x, double y, double z, double inset,
                                                     const Vector3& otherwise) {
  const double r = std::sqrt(x * x + y * y + z * z);
  const double s = r > 0 ? r : 1;
  return {r - inset, r > 0 ? x / s : otherwise.x(), r > 0 ? y / s : otherwise.y(),
          r > 0 ? z / s : otherwise.z()};
}

[[gnu::always_inline]] inline NearSurface near_surface(const Sphere& sphere, double x, double y,
                                                       double z, double) {
  return about_core(x, y, z, sphere.radius, Vector3::UnitZ());
}

/// `side`: the z that the point came from.
[[gnu::always_inline]] inline NearSurface near_surface(const Plane& plane, double, double, double z,
                                                       double side) {
  const double sign = plane.two_sided && side < 0 ? -1.0 : 1.0;
  return {sign * z, 0, 0, sign};
}

[[gnu::always_inline]] inline NearSurface near_surface(const Capsule& capsule, double x, double y,
                                                       double z, double) {
  const double half = capsule.length / 2;
  const double below = z < half ? z : half;
  const double on_axis = below > -half ? below : -half;
  return about_core(x, y, z - on_axis, capsule.radius, Vector3::UnitX());
}

[[gnu::always_inline]] inline NearSurface near_surface(const Cuboid& box, double x, double y,
                                                       double z, double) {
  // Beyond the faces on its side.
  const double bx = std::abs(x) - box.size.x() / 2;
  const double by = std::abs(y) - box.size.y() / 2;
  const double bz = std::abs(z) - box.size.z() / 2;
  const double yz = by > bz ? by : bz;
  const double nearest = bx > yz ? bx : yz;
  const double ox = bx > 0 ? bx : 0, oy = by > 0 ? by : 0, oz = bz > 0 ? bz : 0;
  const double r = std::sqrt(ox * ox + oy * oy + oz * oz);
  const double s = r > 0 ? r : 1;
  const bool inside = nearest <= 0;

  // Inside, along the first axis of those nearest.
  const double ax = bx >= yz ? 1.0 : 0.0;
  const double ay = bx >= yz ? 0.0 : (by >= bz ? 1.0 : 0.0);
  const double az = 1 - ax - ay;
  return {inside ? nearest : r, (x < 0 ? -1.0 : 1.0) * (inside ? ax : ox / s),
          (y < 0 ? -1.0 : 1.0) * (inside ? ay : oy / s),
          (z < 0 ? -1.0 : 1.0) * (inside ? az : oz / s)};
}

[[gnu::always_inline]] inline NearSurface near_surface(const Cylinder& cylinder, double x, double y,
                                                       double z, double) {
  const double rho = std::sqrt(x * x + y * y);
  const double scale = rho > 0 ? rho : 1;
  // Beyond its side and the end on this side.
  const double br = rho - cylinder.radius;
  const double bz = std::abs(z) - cylinder.length / 2;
  const double nearest = br > bz ? br : bz;
  const double outwards = br > 0 ? br : 0, along = bz > 0 ? bz : 0;
  const double r = std::sqrt(outwards * outwards + along * along);
  const double s = r > 0 ? r : 1;
  const bool inside = nearest <= 0;
  const double radial = inside ? (br >= bz ? 1.0 : 0.0) : outwards / s;
  const double axial = inside ? (br >= bz ? 0.0 : 1.0) : along / s;
  return {inside ? nearest : r, radial * (rho > 0 ? x / scale : 1), radial * (y / scale),
          (z < 0 ? -1.0 : 1.0) * axial};
}

inline NearSurface near_surface(const MeshShape& mesh, double x, double y, double z, double) {
  const auto [value, normal] = mesh.file->solid.distance({x, y, z});
  return {value - mesh.padding, normal.x(), normal.y(), normal.z()};
}

}  // namespace clothsim
