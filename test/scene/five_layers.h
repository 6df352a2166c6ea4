#pragma once

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "clothsim/geometry/closest_points.h"
#include "clothsim/geometry/intersections.h"
#include "verification/testing.h"

namespace clothsim::test {

inline constexpr int cells_a_layer = 5;

/// A strip above the ground that five_layers() folds.
inline Scene strip_for_layers() {
  Scene scene;
  scene.cloth.width = 0.12;
  scene.cloth.columns = 4;
  scene.cloth.rows = 5 * cells_a_layer + 1;
  scene.cloth.self_collision = SelfCollision::surface;
  scene.colliders = {{"ground", Plane{}, Pose{}, 0.5, ""}};
  return scene;
}

/// The strip lies to and fro in layers that are 4 cm apart.
inline State five_layers(const Simulator& simulator) {
  State state = simulator.state();
  for (int row = 0; row < simulator.cloth().rows; ++row) {
    const int layer = std::min(row / cells_a_layer, 4);
    const int along = row - layer * cells_a_layer;
    const double y = 0.04 * (layer % 2 == 0 ? along : cells_a_layer - along);
    const double z = 0.005 + 0.04 * layer + 0.04 / cells_a_layer * along;
    for (int column = 0; column < 4; ++column) {
      state.positions.row(row * 4 + column) << 0.04 * column, y, z;
    }
  }
  EXPECT_EQ(count_intersections(simulator.cloth(), state.positions), 0);
  return state;
}

/// For each point the distance to the nearest triangle that is more than half a layer away along
/// the strip [m], in ascending order.
inline std::vector<double> distances_of_layers(const Simulator& simulator) {
  const Points& x = simulator.state().positions;
  std::vector<double> distances;
  for (int i = 0; i < x.rows(); ++i) {
    double least = 1;
    for (const auto& [a, b, c] : simulator.cloth().triangles) {
      const auto rows_apart = [&](int k) { return std::abs(k / 4 - i / 4); };
      if (std::min({rows_apart(a), rows_apart(b), rows_apart(c)}) <= cells_a_layer / 2) continue;
      const auto w = closest_on_triangle(row(x, i), row(x, a), row(x, b), row(x, c));
      const Vector3 closest = w[0] * row(x, a) + w[1] * row(x, b) + w[2] * row(x, c);
      least = std::min(least, (row(x, i) - closest).norm());
    }
    distances.push_back(least);
  }
  std::sort(distances.begin(), distances.end());
  return distances;
}

}  // namespace clothsim::test
