#pragma once

#include "clothsim/shapes/sphere.h"

namespace clothsim {

/// All points within `radius` of the z axis of its own frame from -length / 2 to length / 2.
struct Capsule {
  static constexpr const char* name = "capsule";
  double length = 0.4;  // [m] between the centres of its round ends
  double radius = 0.1;  // [m]

  // Members that shape.h requires.
  static constexpr bool is_convex = true;
  bool operator==(const Capsule& c) const { return length == c.length && radius == c.radius; }
  double safe_depth() const { return radius / 2; }
  double bounding_radius() const { return length / 2 + radius; }
  double corner_distance(double edge, double offset) const {
    return Sphere{radius}.corner_distance(edge, offset);
  }
  [[gnu::always_inline]] NearSurface near_surface(double x, double y, double z, double) const {
    const double half = length / 2;
    const double below = z < half ? z : half;
    const double on_axis = below > -half ? below : -half;
    return about_core(x, y, z - on_axis, radius, Vector3::UnitX());
  }
  Vector3 support(const Vector3& direction) const {
    return Vector3(0, 0, direction.z() < 0 ? -length / 2 : length / 2) + radius * direction;
  }
  std::optional<double> entry(const Vector3& from, const Vector3& displacement,
                              double offset) const;
  std::optional<FaceDistance> face_distance(const Triangle&, double reach) const;
  void visit_lines(const Triangle&, const Vector3&, double, const VisitLine& visit) const {
    visit({0, 0, -length / 2}, {0, 0, length / 2}, radius);
  }
  bool may_touch(const Box&, const Triangle*, double reach) const;
};

}  // namespace clothsim
