#pragma once

#include "clothsim/model/cloth.h"
#include "clothsim/model/cloth_spec.h"

namespace clothsim {

/// The cloth of `spec`, a mesh or a grid: see add_triangle_fabric() and make_grid(). `gravity`
/// [m/s^2], the magnitude, decides whether points are enough for automatic self collision of a
/// grid; a mesh has that of surfaces. Throws InvalidValue.
Cloth make_cloth(const ClothSpec& spec, double gravity = 9.8);

}  // namespace clothsim
