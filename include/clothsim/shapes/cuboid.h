#pragma once

#include "clothsim/shapes/shape_answers.h"

namespace clothsim {

/// A box about the origin of its own frame, along its axes.
struct Cuboid {
  static constexpr const char* name = "box";
  Vector3 size{0.4, 0.4, 0.4};  // [m]

  // Members that shape.h requires.
  static constexpr bool is_convex = true;
  bool operator==(const Cuboid& other) const { return size == other.size; }
  double safe_depth() const { return size.minCoeff() / 4; }
  double bounding_radius() const { return size.norm() / 2; }
  double corner_distance(double, double) const { return infinity; }
  [[gnu::always_inline]] NearSurface near_surface(double x, double y, double z, double) const {
    // Distances beyond the faces on the point's side.
    const double bx = std::abs(x) - size.x() / 2;
    const double by = std::abs(y) - size.y() / 2;
    const double bz = std::abs(z) - size.z() / 2;
    const double yz = by > bz ? by : bz;
    const double nearest = bx > yz ? bx : yz;
    const double ox = bx > 0 ? bx : 0, oy = by > 0 ? by : 0, oz = bz > 0 ? bz : 0;
    const double r = std::sqrt(ox * ox + oy * oy + oz * oz);
    const double s = r > 0 ? r : 1;
    const bool inside = nearest <= 0;

    // Inside: along the first of the axes with the nearest face.
    const double ax = bx >= yz ? 1.0 : 0.0;
    const double ay = bx >= yz ? 0.0 : (by >= bz ? 1.0 : 0.0);
    const double az = 1 - ax - ay;
    return {inside ? nearest : r, (x < 0 ? -1.0 : 1.0) * (inside ? ax : ox / s),
            (y < 0 ? -1.0 : 1.0) * (inside ? ay : oy / s),
            (z < 0 ? -1.0 : 1.0) * (inside ? az : oz / s)};
  }
  Vector3 support(const Vector3& direction) const {
    return {direction.x() < 0 ? -size.x() / 2 : size.x() / 2,
            direction.y() < 0 ? -size.y() / 2 : size.y() / 2,
            direction.z() < 0 ? -size.z() / 2 : size.z() / 2};
  }
  std::optional<double> entry(const Vector3& from, const Vector3& displacement,
                              double offset) const;
  std::optional<FaceDistance> face_distance(const Triangle&, double reach) const;
  void visit_lines(const Triangle&, const Vector3& normal, double reach, const VisitLine&) const;
  bool may_touch(const Box&, const Triangle*, double reach) const;
};

}  // namespace clothsim
