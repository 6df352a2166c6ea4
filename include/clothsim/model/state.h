#pragma once

#include "clothsim/model/types.h"

namespace clothsim {

/// Everything about a cloth that changes while it moves.
struct State {
  Points positions;   // [m], N x 3, row-major over the grid: point (column, row) is row * columns +
                      // column
  Points velocities;  // [m/s], N x 3
  double time = 0;    // [s] since the scene's start
};

}  // namespace clothsim
