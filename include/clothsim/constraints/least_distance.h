#pragma once

#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/shapes/moving_collider.h"

namespace clothsim {

/// Least distance [m] from enabled colliders of the free points and triangles of a cloth, at
/// `positions`, that are nearer than their offset; negative inside. cloth.offset where none is.
double least_distance(const std::vector<MovingCollider>&, const Cloth&, const Points& positions);

}  // namespace clothsim
