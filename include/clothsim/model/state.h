#pragma once

#include "clothsim/model/types.h"

namespace clothsim {

/// Velocities from outside are below this in each component [m/s]: three times the speed of sound,
/// at which contact takes seconds a frame, and the time grows with the speed.
inline constexpr double max_given_speed = 1e3;

/// The state of a cloth: all that changes during the simulation.
struct State {
  Points positions;   // [m], N x 3, row-major over the grid: point (column, row) is row * columns +
                      // column
  Points velocities;  // [m/s], N x 3
  double time = 0;    // [s] since the scene's start
};

}  // namespace clothsim
