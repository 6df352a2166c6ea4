#include "clothsim/search/unfolded.h"

#include <algorithm>
#include <cmath>

namespace clothsim {
namespace {

/// Least and most of q . f over the box.
std::array<double, 2> range_along(const Vector3& q, const Eigen::AlignedBox3d& box) {
  const double middle = q.dot(box.center());
  const double spread = q.cwiseAbs().dot(box.sizes()) / 2;
  return {middle - spread, middle + spread};
}

}  // namespace

void GradientBounds::extend(const GradientBounds& other) {
  along_row.extend(other.along_row);
  along_column.extend(other.along_column);
}

GradientBounds gradient_bounds(const Cloth& cloth, const Points& positions, int first_column,
                               int first_row, int columns, int rows) {
  Box along_row, along_column;  // between neighbours
  for (int r = first_row; r <= first_row + rows; ++r) {
    for (int c = first_column; c <= first_column + columns; ++c) {
      const int i = r * cloth.columns + c;
      const Vector3 x = row(positions, i);
      if (c < first_column + columns) along_row.extend(row(positions, i + 1) - x);
      if (r < first_row + rows) along_column.extend(row(positions, i + cloth.columns) - x);
    }
  }
  const auto over_rest_length = [&](const Box& box, int neighbour) {
    const double length =
        (row(cloth.rest_positions, neighbour) - row(cloth.rest_positions, 0)).norm();
    return Box(box.min() / length, box.max() / length);
  };
  return {over_rest_length(along_row, 1), over_rest_length(along_column, cloth.columns)};
}

double least_stretch(const GradientBounds& bounds) {
  // Q nearest to the middle of the bounds.
  const Vector3 u = bounds.along_row.center().normalized();
  const Vector3 v = bounds.along_column.center().normalized();
  const Vector3 sum = (u + v).normalized(), difference = (u - v).normalized();
  const Vector3 q1 = std::sqrt(0.5) * (sum + difference), q2 = std::sqrt(0.5) * (sum - difference);

  // Gershgorin's circles.
  const double diagonal =
      std::min(range_along(q1, bounds.along_row)[0], range_along(q2, bounds.along_column)[0]);
  const auto across1 = range_along(q1, bounds.along_column);
  const auto across2 = range_along(q2, bounds.along_row);
  const double across =
      std::max(std::abs(across1[0] + across2[0]), std::abs(across1[1] + across2[1])) / 2;
  return diagonal - across;
}

}  // namespace clothsim
