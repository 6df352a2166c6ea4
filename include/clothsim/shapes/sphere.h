#pragma once

#include "clothsim/shapes/shape_answers.h"

namespace clothsim {

/// Ball about the origin of its own frame.
struct Sphere {
  static constexpr const char* name = "sphere";
  double radius = 0.2;  // [m]

  // Members that shape.h requires.
  static constexpr bool is_convex = true;
  bool operator==(const Sphere& other) const { return radius == other.radius; }
  double safe_depth() const { return radius / 2; }
  double bounding_radius() const { return radius; }
  double corner_distance(double edge, double offset) const;
  [[gnu::always_inline]] NearSurface near_surface(double x, double y, double z, double) const {
    return about_core(x, y, z, radius, Vector3::UnitZ());
  }
  Vector3 support(const Vector3& direction) const { return radius * direction; }
  std::optional<double> entry(const Vector3& from, const Vector3& displacement,
                              double offset) const;
  std::optional<FaceDistance> face_distance(const Triangle&, double reach) const;
  void visit_lines(const Triangle&, const Vector3&, double, const VisitLine&) const {}
  bool may_touch(const Box&, const Triangle*, double reach) const;
};

}  // namespace clothsim
