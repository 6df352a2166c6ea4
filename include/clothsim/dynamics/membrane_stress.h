#pragma once

#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// Stress of each triangle in its own plane [N/m], a force per width at rest: along rows, along
/// columns and in shear, T x 3 in the order of cloth.triangles. `tensions` [N] are of the springs
/// in the order of cloth.springs, at `state`. In a grid a spring of rest length L that lies along D
/// at rest adds
///   T / (L A) D D^T
/// to the area A at rest that it runs through: half on each side of an edge, all of it on the
/// cloth's own edge, and the cells of a fabric add their second Piola-Kirchhoff stress. Averages
/// over a cell or more are the stress of the sheet that the springs represent; single triangles of
/// a cell differ as their springs do. Bends of a fabric have no part in it.
///
/// In a mesh the stress is that of the membrane, along warp, along weft and in shear: the second
/// Piola-Kirchhoff stress. The tension of an edge beyond the membrane's, from the strain limit, is
/// added as in a grid.
Points membrane_stress(const Cloth&, const State&, const std::vector<double>& tensions);

}  // namespace clothsim
