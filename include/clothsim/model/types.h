#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>

namespace clothsim {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;

inline constexpr double infinity = std::numeric_limits<double>::infinity();

/// N x 3, column-major: all x, then all y, then all z, each contiguous, so that kernels vectorise.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::ColMajor>;

/// Point i.
inline Vector3 row(const Points& points, int i) {
  return {points(i, 0), points(i, 1), points(i, 2)};
}

/// Length of the longest of some vectors.
double longest_row(const Points& vectors);

/// Distance of the point farthest from `origin`.
double farthest_from(const Vector3& origin, const Points&);

/// Length of the longest displacement of a point.
double longest_displacement(const Points& from, const Points& to);

/// Length of the longest of some vectors, or displacements, relative to the mean of all. No
/// vectors: 0.
double longest_beyond_mean(const Points& vectors);
double longest_beyond_mean(const Points& from, const Points& to);

/// One number per point.
using Scalars = Eigen::VectorXd;

}  // namespace clothsim
