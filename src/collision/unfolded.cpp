#include "clothsim/collision/unfolded.h"

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

GradientBounds gradient_bounds(const Cloth& cloth, const Points& positions, int column, int row) {
  const auto gradient = [&](int a, int b) {
    const double length = (cloth.rest_positions.row(b) - cloth.rest_positions.row(a)).norm();
    return Vector3((positions.row(b) - positions.row(a)).transpose() / length);
  };
  const int i = row * cloth.columns + column, above = i + cloth.columns;
  GradientBounds bounds;
  bounds.along_row.extend(gradient(i, i + 1)).extend(gradient(above, above + 1));
  bounds.along_column.extend(gradient(i, above)).extend(gradient(i + 1, above + 1));
  return bounds;
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
