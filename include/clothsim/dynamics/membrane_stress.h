#pragma once

#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// Stress of each triangle in its own plane [N/m], a force per width at rest: along rows, along
/// columns and in shear, T x 3 in the order of cloth.triangles. `tensions` [N] are of the springs
/// in the order of cloth.springs. A spring of rest length L that lies along D at rest puts
///   T / (L A) D D^T
/// on the area A at rest that it runs through: half on each side of an edge, all of it on the
/// cloth's own edge. Averages over a cell or more are the stress of the sheet that the springs
/// stand for; single triangles of a cell differ as their springs do. Bends of a fabric carry none.
Points membrane_stress(const Cloth&, const std::vector<double>& tensions);

}  // namespace clothsim
