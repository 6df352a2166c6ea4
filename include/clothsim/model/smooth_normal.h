#pragma once

#include <array>
#include <cmath>

#include "clothsim/model/types.h"

namespace clothsim {

/// The normal of a triangle, n = N / sqrt(|N|^2 + e^2) with N = (x1 - x0) x (x2 - x0): of length
/// nearly 1, but 0 and with bounded derivatives where the triangle has collapsed.
class SmoothNormal {
 public:
  /// `a`, `b`, `c`: the corners [m]. `softening`: e [m^2].
  SmoothNormal(const Vector3& a, const Vector3& b, const Vector3& c, double softening)
      : sides_{b - c, c - a, a - b} {
    const Vector3 area2 = sides_[1].cross(sides_[2]);
    inverse_ = 1 / std::sqrt(area2.squaredNorm() + softening * softening);
    normal_ = inverse_ * area2;
  }
  /// The normal of the first three points of `bend`, a PatchBend or a CurvedTriangle.
  template <typename Bend>
  SmoothNormal(const Bend& bend, const Points& positions)
      : SmoothNormal(row(positions, bend.points[0]), row(positions, bend.points[1]),
                     row(positions, bend.points[2]), bend.softening) {}

  const Vector3& normal() const { return normal_; }

  /// dn / dt for these velocities of the corners [1/s].
  Vector3 rate(const Vector3& a, const Vector3& b, const Vector3& c) const {
    return across(a.cross(sides_[0]) + b.cross(sides_[1]) + c.cross(sides_[2]));
  }

  /// Bound on |dn / dx_k| of a corner [1/m].
  double slope(std::size_t corner) const { return inverse_ * sides_[corner].norm(); }

  /// dn / dx_k of a corner [1/m].
  Eigen::Matrix3d derivative(std::size_t corner) const {
    Eigen::Matrix3d by_corner;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      by_corner.col(axis) = across(Vector3::Unit(axis).cross(sides_[corner]));
    }
    return by_corner;
  }

  /// (dn / dx_k)^T times `gradient`, the derivative of a function of n.
  Vector3 pulled_back(std::size_t corner, const Vector3& gradient) const {
    return sides_[corner].cross(across(gradient));
  }

 private:
  /// The change of n with that of N; symmetric.
  Vector3 across(const Vector3& d) const { return inverse_ * (d - normal_.dot(d) * normal_); }

  std::array<Vector3, 3> sides_;  // opposite to each corner: dN = sum of dx_k x side
  double inverse_;                // [1/m^2]
  Vector3 normal_;
};

}  // namespace clothsim
