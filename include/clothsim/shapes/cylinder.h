#pragma once

#include "clothsim/shapes/shape_answers.h"

namespace clothsim {

/// All points within `radius` of the z axis of its own frame, with flat ends at -length / 2 and
/// length / 2.
struct Cylinder {
  static constexpr const char* name = "cylinder";
  double length = 0.4;  // [m]
  double radius = 0.1;  // [m]

  // Members that shape.h requires.
  static constexpr bool is_convex = true;
  bool operator==(const Cylinder& c) const { return length == c.length && radius == c.radius; }
  double safe_depth() const { return (radius < length / 2 ? radius : length / 2) / 2; }
  double bounding_radius() const { return std::hypot(length / 2, radius); }
  double corner_distance(double, double) const { return infinity; }
  [[gnu::always_inline]] NearSurface near_surface(double x, double y, double z, double) const {
    const double rho = std::sqrt(x * x + y * y);
    const double scale = rho > 0 ? rho : 1;
    // Distances beyond the side and beyond the end on the point's side.
    const double br = rho - radius;
    const double bz = std::abs(z) - length / 2;
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
  Vector3 support(const Vector3& direction) const;
  std::optional<double> entry(const Vector3& from, const Vector3& displacement,
                              double offset) const;
  std::optional<FaceDistance> face_distance(const Triangle&, double reach) const;
  void visit_lines(const Triangle&, const Vector3& normal, double reach, const VisitLine&) const;
  bool may_touch(const Box&, const Triangle*, double reach) const;
};

}  // namespace clothsim
