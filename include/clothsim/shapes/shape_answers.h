// Results of queries to shapes, each in the shape's own frame.
#pragma once

#include <array>
#include <cmath>
#include <functional>

#include "clothsim/geometry/box_tree.h"
#include "clothsim/geometry/intersections.h"

namespace clothsim {

/// Signed distance [m], negative inside, and its gradient, the unit normal into free space.
struct Distance {
  double value;
  Vector3 normal;
};

/// The same as separate numbers, for vector loops.
struct NearSurface {
  double value;    // [m]
  double x, y, z;  // of the normal

  operator Distance() const { return {value, {x, y, z}}; }
};

/// Length (x, y, z) - inset [m], and its direction; `otherwise` is the direction where the length
/// is 0.
[[gnu::always_inline]] inline NearSurface about_core(double x, double y, double z, double inset,
                                                     const Vector3& otherwise) {
  const double r = std::sqrt(x * x + y * y + z * z);
  const double s = r > 0 ? r : 1;
  return {r - inset, r > 0 ? x / s : otherwise.x(), r > 0 ? y / s : otherwise.y(),
          r > 0 ? z / s : otherwise.z()};
}

/// Where a triangle comes closest to a shape, or its shortest way out; the default is infinitely
/// far.
struct FaceDistance {
  /// [m] between them; negative: the shortest way that takes the triangle out.
  double value = infinity;
  Vector3 normal{0, 0, 1};  // unit, from the shape to the triangle, or that way's direction
  std::array<double, 3> weights{1, 0, 0};  // of the corners, at the triangle's point; sum 1
};

/// Gets the ends of a straight line of a shape and the radius about it [m].
using VisitLine = std::function<void(const Vector3& low, const Vector3& high, double radius)>;

}  // namespace clothsim
