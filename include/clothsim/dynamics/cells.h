#pragma once

#include <array>
#include <cstddef>

#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// A cell of a fabric on a grid with one of its strains, see CellRun.
struct Cell {
  std::array<int, 4> corners;
  CellStrain strain;
  double stiffness;  // [J]

  static double sign(std::size_t corner) { return corner == 0 || corner == 1 ? -1 : 1; }
  /// The diagonal that begins or ends at a corner: 0 or 1.
  static std::size_t diagonal_of(std::size_t corner) { return corner == 0 || corner == 3 ? 0 : 1; }

  using Diagonals = std::array<Vector3, 2>;
  /// Differences of their ends' values [m, or m/s].
  Diagonals diagonals(const Points& values) const {
    return {row(values, corners[3]) - row(values, corners[0]),
            row(values, corners[2]) - row(values, corners[1])};
  }

  double value(const Points& positions) const {
    const auto [one, two] = diagonals(positions);
    return strain.p * one.squaredNorm() + strain.q * two.squaredNorm() + strain.r * one.dot(two) -
           strain.rest;
  }
  /// Derivatives of the value by both diagonals [1/m]. That by a corner is the one of its diagonal
  /// times its sign.
  Diagonals gradients(const Points& positions) const {
    const auto [one, two] = diagonals(positions);
    return {2 * strain.p * one + strain.r * two, 2 * strain.q * two + strain.r * one};
  }
  /// Adds `factor` times the derivatives of the value by the corners.
  void add_gradient(const Points& positions, double factor, Points& sum) const {
    const Diagonals by = gradients(positions);
    for (std::size_t c = 0; c < corners.size(); ++c) {
      sum.row(corners[c]) += factor * sign(c) * by[diagonal_of(c)].transpose();
    }
  }
  /// Derivative of the value by time [1/s].
  double rate(const Points& positions, const Points& velocities) const {
    const Diagonals by = gradients(positions), moves = diagonals(velocities);
    return by[0].dot(moves[0]) + by[1].dot(moves[1]);
  }
  /// Derivative of the energy by the value, with internal damping [s] [J].
  double stress(const State& state, double damping) const {
    return stiffness * (value(state.positions) + damping * rate(state.positions, state.velocities));
  }
};

/// The cell of a run with this first corner.
inline Cell cell_of(const CellRun& run, int i) {
  return {{i, i + run.a, i + run.b, i + run.a + run.b}, run.strain, run.stiffness};
}

/// Calls visit(cell) for every strain of every cell, in the order of cloth.cells. Not for hot
/// loops.
template <typename Visitor>
void for_each_cell(const Cloth& cloth, Visitor&& visit) {
  for (const CellRun& run : cloth.cells) {
    for (int i = run.first; i < run.first + run.count; ++i) {
      visit(cell_of(run, i));
    }
  }
}

}  // namespace clothsim
