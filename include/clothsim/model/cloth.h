#pragma once

#include <array>
#include <optional>
#include <vector>

#include "clothsim/model/cloth_spec.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// `count` equal springs that join point first + i to point first + i + offset. Springs that lie
/// in a row of memory share one entry, so that kernels run along it.
struct SpringRun {
  SpringFamily family;
  int first;
  int offset;  // > 0
  int count;
  double rest_length;  // [m]
  double stiffness;    // [N/m]
};

/// What a cloth is: topology, rest lengths, masses. Immutable while it moves.
struct Cloth {
  int columns = 0;
  int rows = 0;
  Points rest_positions;                        // [m], N x 3
  Eigen::Matrix<double, Eigen::Dynamic, 2> uv;  // texture coordinates in [0, 1], N x 2
  std::vector<std::array<int, 3>> triangles;    // counter-clockwise seen from the front
  std::vector<SpringRun> springs;               // of the families switched on
  Scalars mass;                                 // [kg], N
  Scalars inv_mass;                             // [1/kg], N; zero at pins
  std::vector<int> pinned;                      // point ids, ascending
  double damping = 0;                           // [1/s]
  std::optional<double> strain_limit;
  SelfCollision self_collision = SelfCollision::off;  // never automatic
  double friction = 0;                                // of the cloth on itself
  double thickness = 0;                               // [m]

  int num_points() const { return static_cast<int>(rest_positions.rows()); }
  int num_springs() const;
};

}  // namespace clothsim
