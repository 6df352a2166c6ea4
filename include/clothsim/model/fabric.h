#pragma once

#include "clothsim/model/cloth.h"
#include "clothsim/model/cloth_spec.h"

namespace clothsim {

/// Sets the masses, springs, cells and bends of `spec.material.fabric` in a grid whose points are
/// set.
///
/// A point has the mass of the area that it owns: a cell, half of one on an edge, a quarter in a
/// corner.
///
/// Springs along a row have C11 / du times the height that the row owns, springs along a column the
/// same with u and v swapped. Shear acts on the mean sides m_u and m_v of a cell du x dv, as in
/// elements with one point of quadrature: its energy is G du dv g^2 / 2 with g = m_u . m_v / (du
/// dv). A bend along the bias strains a cell half as much as springs along both diagonals, since
/// one diagonal is its chord. With a Poisson's ratio nu a share |nu| of C11 and C22 leaves the
/// springs, and acts with C12 on Green's strains of the mean sides.
///
/// The bending energy is that of a thin plate without Poisson's effect, per area (B_u k_uu^2 + B_v
/// k_vv^2 + 2 sqrt(B_u B_v) k_uv^2) / 2 (Timoshenko & Woinowsky-Krieger, Theory of Plates and
/// Shells, 85, with Huber's twist): with equal B it is the same in all directions. Curvatures are
/// second differences of positions, which makes it quadratic (Bergou et al. 2006, "A quadratic
/// bending model for inextensible surfaces").
void add_fabric(const ClothSpec& spec, Cloth& cloth);

}  // namespace clothsim
