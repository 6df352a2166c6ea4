#pragma once

#include <string>

#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// One line a point in row-major order under the header "x,y,z,vx,vy,vz" [m, m/s]; the digits give
/// back the same doubles.
std::string to_csv(const State&);

/// The surface as binary PLY: float positions [m] and triangles.
std::string to_ply(const Cloth&, const Points& positions);

}  // namespace clothsim
