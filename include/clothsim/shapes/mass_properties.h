#pragma once

#include <optional>

#include "clothsim/shapes/shape.h"

namespace clothsim {

/// Mass properties of a solid of even density, for a mass of 1 kg, in the shape's own frame.
struct MassProperties {
  Vector3 center{0, 0, 0};                // centre of mass [m]
  Matrix3 inertia = Matrix3::Identity();  // about that centre, of the axes of the frame [m^2]
};

/// Those of a shape; empty for a plane and a sheet, which have no volume. A mesh counts without its
/// padding.
std::optional<MassProperties> mass_properties(const Shape&);

}  // namespace clothsim
