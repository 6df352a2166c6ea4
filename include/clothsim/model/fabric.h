#pragma once

#include "clothsim/model/cloth.h"
#include "clothsim/model/cloth_spec.h"

namespace clothsim {

/// Sets the masses, springs and bends of `spec.material.fabric` in a grid whose points are set.
///
/// A point has the mass of the area that it owns: a cell, half of one on an edge, a quarter in a
/// corner. The springs give the moduli of the fabric on cells du x dv of any shape, from equal
/// energies (as Seung & Nelson 1988, "Defects in flexible membranes", do for triangles). Diagonals
/// have G L^2 / (2 du dv) with L^2 = du^2 + dv^2. Springs along a row have (C11 - G du^2 / dv^2) /
/// du times the height that the row owns, springs along a column the same with u and v swapped.
///
/// The bending energy is that of a thin plate without Poisson's effect, per area (B_u k_uu^2 + B_v
/// k_vv^2 + 2 sqrt(B_u B_v) k_uv^2) / 2 (Timoshenko & Woinowsky-Krieger, Theory of Plates and
/// Shells, 85, with Huber's twist): with equal B it is the same in all directions. Curvatures are
/// second differences of positions, which makes it quadratic (Bergou et al. 2006, "A quadratic
/// bending model for inextensible surfaces").
void add_fabric(const ClothSpec& spec, Cloth& cloth);

}  // namespace clothsim
