#pragma once

#include "clothsim/model/cloth.h"

namespace clothsim {

/// Cells along the longer side of a grid, or of a square of a mesh's points; of several cloths the
/// most.
double cells_along(const Cloth&);

/// Extent along x, y and z of the cloth at the start, of several of the largest [m].
Eigen::RowVector3d extent_of(const Cloth&);

}  // namespace clothsim
