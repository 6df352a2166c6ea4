#include "clothsim/model/edge_slope.h"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "clothsim/model/flat_triangle.h"

namespace clothsim {
namespace {

/// Errors of the mean of four points for quadratic functions, in lengths of the edge, below which
/// it stays as it is. With 0.1 strips of uneven meshes hang by 0.5 % of their drop less, and have a
/// quarter fewer bends of more than six points (docs/experiments.md).
constexpr double even_enough = 0.05;
/// Combinations of quadratic functions that the points determine more weakly stay as they are.
/// Without this bound some uneven meshes get frequencies of bending that are three times as high.
constexpr double least_determined = 0.1;

}  // namespace

std::vector<PointShare> slope_across(const std::vector<PointAtEdge>& points) {
  const auto count = static_cast<Eigen::Index>(points.size());
  const Eigen::Vector2d &below = points[2].place, &above = points[3].place;
  const auto height_ratio_of = [&](const Eigen::Vector2d& across) {
    return height_ratio({points[0].place, points[1].place, across});
  };
  // Each slope from the point across to its foot on the edge, whose height is that of both ends.
  Eigen::VectorXd shares = Eigen::VectorXd::Zero(count);
  const double both = above.y() - below.y();
  const auto add_slope = [&](Eigen::Index point, double weight, const Eigen::Vector2d& place) {
    const double slope = weight / place.y();
    shares[point] += slope;
    shares[0] -= slope * (0.5 - place.x());
    shares[1] -= slope * (0.5 + place.x());
  };
  add_slope(2, above.y() / both, below);
  add_slope(3, -below.y() / both, above);

  Eigen::Matrix3Xd linear(3, count), quadratic(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double x = points[static_cast<std::size_t>(i)].place.x(),
                 y = points[static_cast<std::size_t>(i)].place.y();
    linear.col(i) << 1, x, y;
    quadratic.col(i) << x * x, x * y, y * y;
  }
  const Eigen::Vector3d error = quadratic * shares;
  const bool is_exact = count == 4 || error.cwiseAbs().maxCoeff() < even_enough;
  if (!is_exact && std::min(height_ratio_of(below), height_ratio_of(above)) >= least_height_ratio) {
    // Corrections have no part in linear functions.
    const Eigen::MatrixXd in_linear =
        Eigen::HouseholderQR<Eigen::MatrixXd>(linear.transpose()).householderQ() *
        Eigen::MatrixXd::Identity(count, 3);
    const Eigen::MatrixXd parts = quadratic - quadratic * in_linear * in_linear.transpose();
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(parts, Eigen::ComputeThinU | Eigen::ComputeThinV);
    Eigen::VectorXd along = -svd.matrixU().transpose() * error;
    for (Eigen::Index k = 0; k < along.size(); ++k) {
      const double value = svd.singularValues()[k];
      along[k] = value > least_determined ? along[k] / value : 0;
    }
    shares += std::min(1.0, shares.norm() / along.norm()) * svd.matrixV() * along;
  }
  std::vector<PointShare> result;
  for (Eigen::Index i = 0; i < count; ++i) {
    if (i < 4 || shares[i] != 0) {
      result.push_back({points[static_cast<std::size_t>(i)].point, shares[i]});
    }
  }
  return result;
}

}  // namespace clothsim
