#include "clothsim/model/surface.h"

#include <algorithm>

namespace clothsim {
namespace {

// A sum this much shorter than the sum of its terms' lengths is rounding, not a direction.
constexpr double cancelled = 1e-9;

/// Twice the triangle's area times its normal.
Vector3 area_vector(const Points& x, const std::array<int, 3>& t) {
  const Vector3 a = x.row(t[0]), b = x.row(t[1]), c = x.row(t[2]);
  return (b - a).cross(c - a);
}

/// Any unit vector perpendicular to unit `n`.
Vector3 perpendicular(const Vector3& n) { return n.unitOrthogonal(); }

}  // namespace

Points vertex_normals(const Points& positions, const std::vector<std::array<int, 3>>& triangles) {
  // Sum the area vectors around each point, and their lengths.
  Points normals = Points::Zero(positions.rows(), 3);
  Scalars area = Scalars::Zero(positions.rows());
  for (const auto& triangle : triangles) {
    const Vector3 n = area_vector(positions, triangle);
    const double length = n.norm();
    for (const int i : triangle) {
      normals.row(i) += n.transpose();
      area[i] += length;
    }
  }

  bool complete = true;
  for (Eigen::Index i = 0; i < normals.rows(); ++i) {
    const double length = normals.row(i).norm();
    if (length > cancelled * area[i]) {
      normals.row(i) /= length;
    } else {
      normals.row(i).setZero();
      complete = false;
    }
  }
  if (complete) return normals;

  // Where the sum cancels, take the largest triangle alone.
  Scalars largest = Scalars::Zero(positions.rows());
  Points fallback = Points::Zero(positions.rows(), 3);
  fallback.col(2).setOnes();
  for (const auto& triangle : triangles) {
    const Vector3 n = area_vector(positions, triangle);
    const double length = n.norm();
    for (const int i : triangle)
      if (length > largest[i]) {
        largest[i] = length;
        fallback.row(i) = n.transpose() / length;
      }
  }
  for (Eigen::Index i = 0; i < normals.rows(); ++i)
    if (normals.row(i).isZero(0)) normals.row(i) = fallback.row(i);
  return normals;
}

Points vertex_tangents(const Points& positions, const Eigen::Matrix<double, Eigen::Dynamic, 2>& uv,
                       const std::vector<std::array<int, 3>>& triangles, const Points& normals) {
  // dP/du of each triangle, weighted by its area in u and v.
  Points tangents = Points::Zero(positions.rows(), 3);
  for (const auto& t : triangles) {
    const Vector3 e1 = positions.row(t[1]) - positions.row(t[0]);
    const Vector3 e2 = positions.row(t[2]) - positions.row(t[0]);
    const Eigen::Vector2d d1 = uv.row(t[1]) - uv.row(t[0]);
    const Eigen::Vector2d d2 = uv.row(t[2]) - uv.row(t[0]);
    const double orientation = d1.x() * d2.y() - d2.x() * d1.y() < 0 ? -1 : 1;
    const Vector3 along_u = orientation * (d2.y() * e1 - d1.y() * e2);
    for (const int i : t) tangents.row(i) += along_u.transpose();
  }

  for (Eigen::Index i = 0; i < tangents.rows(); ++i) {
    const Vector3 n = normals.row(i), t = tangents.row(i);
    const Vector3 flat = t - n * n.dot(t);
    const double length = flat.norm();
    tangents.row(i) = length > cancelled * t.norm() ? Vector3(flat / length) : perpendicular(n);
  }
  return tangents;
}

double longest_edge(const Points& positions, const std::vector<std::array<int, 3>>& triangles) {
  double longest_squared = 0;
  for (const auto& t : triangles)
    for (int k = 0; k < 3; ++k)
      longest_squared =
          std::max(longest_squared, (positions.row(t[static_cast<std::size_t>((k + 1) % 3)]) -
                                     positions.row(t[static_cast<std::size_t>(k)]))
                                        .squaredNorm());
  return std::sqrt(longest_squared);
}

}  // namespace clothsim
