#pragma once

#include <vector>

#include "clothsim/shapes/solid.h"

namespace clothsim {

/// The shells of a solid, each connected and closed, in groups none of which has two that touch or
/// overlap: where one does, the nearest face does not tell inside from outside. A hollow goes with
/// the shell around it. One group, of all, where none overlaps another.
std::vector<TriangleSoup> split_overlapping(const Solid&);

}  // namespace clothsim
