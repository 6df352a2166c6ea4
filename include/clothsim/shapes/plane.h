#pragma once

#include "clothsim/shapes/shape_answers.h"

namespace clothsim {

/// Plane z = 0 of its own frame, normal +z. One-sided: all of z < 0 is solid. Two-sided: a sheet
/// that keeps points on the side they are on.
struct Plane {
  static constexpr const char* name = "plane";
  bool two_sided = false;

  // Members that shape.h requires. For a plane the corners of triangles are enough.
  static constexpr bool is_convex = true;
  bool operator==(const Plane& other) const { return two_sided == other.two_sided; }
  double safe_depth() const { return infinity; }
  double bounding_radius() const { return infinity; }
  double corner_distance(double, double offset) const { return offset; }
  [[gnu::always_inline]] NearSurface near_surface(double, double, double z, double side) const {
    const double sign = two_sided && side < 0 ? -1.0 : 1.0;
    return {sign * z, 0, 0, sign};
  }
  std::optional<double> entry(const Vector3&, const Vector3&, double) const { return {}; }
  std::optional<FaceDistance> face_distance(const Triangle&, double) const { return {}; }
  void visit_lines(const Triangle&, const Vector3&, double, const VisitLine&) const {}
  bool may_touch(const Box&, const Triangle*, double) const { return false; }
};

}  // namespace clothsim
