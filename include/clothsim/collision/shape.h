#pragma once

#include <variant>

#include "clothsim/model/types.h"

namespace clothsim {

/// Signed distance [m], negative inside, and its gradient, the unit normal into free space.
struct Distance {
  double value;
  Vector3 normal;
};

/// Ball about the origin of its own frame.
struct Sphere {
  double radius;  // [m]
};

/// Plane z = 0 of its own frame, normal +z. One-sided: all of z < 0 is solid. Two-sided: a sheet
/// that holds whatever is on either side.
struct Plane {
  bool two_sided = false;
};

using Shape = std::variant<Sphere, Plane>;

/// Distance from `point`, in the shape's own frame, to its surface. At the centre of a sphere the
/// normal is +z. A two-sided plane counts as solid on the side away from `side_of`.
Distance signed_distance(const Sphere&, const Vector3& point, const Vector3& side_of);
Distance signed_distance(const Plane&, const Vector3& point, const Vector3& side_of);

}  // namespace clothsim
