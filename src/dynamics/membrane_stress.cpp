#include "clothsim/dynamics/membrane_stress.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "clothsim/dynamics/cells.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/triangle_forces.h"

namespace clothsim {
namespace {

/// CellTriangles of the grid: each has two triangles, on either side of its diagonal from its first
/// point.
class CellTriangles {
 public:
  explicit CellTriangles(const Cloth& cloth) : columns_(cloth.columns - 1), rows_(cloth.rows - 1) {}

  /// Triangles of a cell; -1 where there is none.
  int below_diagonal(int column, int row) const { return triangle(column, row, 0); }
  int above_diagonal(int column, int row) const { return triangle(column, row, 1); }

 private:
  int triangle(int column, int row, int which) const {
    const bool is_there = column >= 0 && column < columns_ && row >= 0 && row < rows_;
    return is_there ? 2 * (row * columns_ + column) + which : -1;
  }

  int columns_;
  int rows_;
};

/// The triangles that a spring to a neighbour runs through or along; -1 where there is none.
std::array<int, 2> cells_at(const CellTriangles& cells, int column, int row, int right, int up) {
  if (up == 0) return {cells.below_diagonal(column, row), cells.above_diagonal(column, row - 1)};
  if (right == 0) return {cells.above_diagonal(column, row), cells.below_diagonal(column - 1, row)};
  const int left = right > 0 ? column : column - 1;
  return {cells.below_diagonal(left, row), cells.above_diagonal(left, row)};
}

/// The second Piola-Kirchhoff stress of the cells, dW/dE, on both triangles of each.
void add_cells(const Cloth& cloth, const State& state, const CellTriangles& cells, double wide,
               double high, Points& stress) {
  for_each_cell(cloth, [&](const Cell& cell) {
    const auto& [p, q, r, rest] = cell.strain;
    const double stress_by_area = cell.stress(state, cloth.internal_damping[0]) / (wide * high);
    const Eigen::RowVector3d added =
        2 * stress_by_area *
        Eigen::RowVector3d(wide * wide * (p + q - r), high * high * (p + q + r),
                           wide * high * (p - q));
    const int column = cell.corners[0] % cloth.columns, row = cell.corners[0] / cloth.columns;
    stress.row(cells.below_diagonal(column, row)) += added;
    stress.row(cells.above_diagonal(column, row)) += added;
  });
}

/// A pull s on an edge D at rest adds 2 s / A D D^T.
Points stress_of_mesh(const Cloth& cloth, const State& state, const std::vector<double>& tensions) {
  const TriangleFabric& fabric = *cloth.triangle_fabric;
  const Points* const velocities = is_damped(cloth) ? &state.velocities : nullptr;
  const std::vector<double> of_membrane = edge_tensions(cloth, state.positions, velocities);
  Points stress(static_cast<Eigen::Index>(cloth.triangles.size()), 3);
  for (std::size_t t = 0; t < cloth.triangles.size(); ++t) {
    const TriangleFabric::Triangle& triangle = fabric.triangles[t];
    Vector3 pulls = triangle_pulls(cloth, t, state.positions, velocities);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto e = static_cast<std::size_t>(triangle.edges[k]);
      const auto i = static_cast<Eigen::Index>(k);
      const bool has_both =
          std::max(fabric.pulls_of[e][0], fabric.pulls_of[e][1]) < fabric.no_pull();
      const double beyond = (tensions.at(e) - of_membrane[e]) / (has_both ? 2 : 1);
      pulls[i] += beyond / (2 * std::sqrt(triangle.rest2[i]));
    }
    stress.row(static_cast<Eigen::Index>(t)) =
        2 / triangle.area * pulls.transpose() * triangle.products;
  }
  return stress;
}

}  // namespace

Points membrane_stress(const Cloth& cloth, const State& state,
                       const std::vector<double>& tensions) {
  if (cloth.is_mesh()) return stress_of_mesh(cloth, state, tensions);
  Points stress = Points::Zero(static_cast<Eigen::Index>(cloth.triangles.size()), 3);
  if (cloth.triangles.empty()) return stress;
  const CellTriangles cells(cloth);
  const Points& rest = cloth.rest_positions;
  const double wide = (rest.row(1) - rest.row(0)).norm();
  const double high = (rest.row(cloth.columns) - rest.row(0)).norm();
  const double area = wide * high / 2;
  std::size_t spring = 0;
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const int column = a % cloth.columns, row = a / cloth.columns;
    const int right = b % cloth.columns - column, up = b / cloth.columns - row;
    const int steps = std::max(std::abs(right), up);  // to neighbours, all alike
    const double x = right * wide, y = up * high;
    const Vector3 share =
        tensions.at(spring++) / (run.rest_length * area * steps) * Vector3(x * x, y * y, x * y);
    for (int step = 0; step < steps; ++step) {
      const auto sides = cells_at(cells, column + step * right / steps, row + step * up / steps,
                                  right / steps, up / steps);
      const bool has_both = sides[0] >= 0 && sides[1] >= 0;
      for (const int triangle : sides) {
        if (triangle >= 0) stress.row(triangle) += (has_both ? 0.5 : 1) * share.transpose();
      }
    }
  });
  add_cells(cloth, state, cells, wide, high, stress);
  return stress;
}

}  // namespace clothsim
