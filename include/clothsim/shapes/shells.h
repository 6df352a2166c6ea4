#pragma once

#include <vector>

#include "clothsim/shapes/solid.h"

namespace clothsim {

/// The shells of a solid, each connected and closed, in groups without shells that touch or
/// overlap: in an overlap the nearest face does not tell inside from outside. A hollow goes with
/// the shell around it. A single group of all shells where none overlaps another.
std::vector<TriangleSoup> split_overlapping(const Solid&);

}  // namespace clothsim
