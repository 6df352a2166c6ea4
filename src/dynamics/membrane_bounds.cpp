#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "clothsim/dynamics/triangle_forces.h"

namespace clothsim {
namespace {

/// Largest eigenvalue of `stretch` times `by_mass`, both positive semidefinite.
double largest_product(const Eigen::Matrix3d& stretch, const Eigen::Matrix3d& by_mass) {
  const Eigen::LDLT<Eigen::Matrix3d> ldlt(stretch);
  const Eigen::Matrix3d lower = ldlt.transpositionsP().transpose() *
                                Eigen::Matrix3d(ldlt.matrixL()) *
                                ldlt.vectorD().cwiseMax(0).cwiseSqrt().asDiagonal();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(lower.transpose() * by_mass * lower, Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[2];
}

/// Largest stiffness of a triangle across its edges [N/m]: at most 3 of 2 s by point.
double stiffness_across(const TriangleFabric::Triangle& triangle, const Vector3& q) {
  return 6 * std::max((triangle.stretch * (q - triangle.rest2)).maxCoeff(), 0.0);
}

}  // namespace

std::vector<double> membrane_bounds(const Cloth& cloth, const Points& positions,
                                    std::vector<double> min_omega) {
  const std::vector<TriangleFabric::Triangle>& triangles = cloth.triangle_fabric->triangles;
  Scalars stiffness(static_cast<Eigen::Index>(triangles.size()));
  Scalars sums = Scalars::Zero(cloth.num_points());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vector3 q = squared_edges(cloth.triangles[t], positions);
    const double along = (triangles[t].stretch * squared_derivatives(q, Vector3::Ones())).trace();
    const auto i = static_cast<Eigen::Index>(t);
    stiffness[i] = 4 * along + stiffness_across(triangles[t], q);
    for (const int corner : cloth.triangles[t]) sums[corner] += stiffness[i];
  }
  std::vector<double>& bounds = min_omega;
  for (double& bound : bounds) bound *= bound;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vector3 q = squared_edges(cloth.triangles[t], positions);
    const double own = stiffness[static_cast<Eigen::Index>(t)];
    if (own == 0) continue;
    const int piece = cloth.triangle_fabric->piece_of(cloth.triangles[t][0]);
    double& omega2 = bounds[static_cast<std::size_t>(piece)];
    Vector3 w;
    for (std::size_t k = 0; k < 3; ++k) {
      const int corner = cloth.triangles[t][k];
      w[static_cast<Eigen::Index>(k)] = cloth.inv_mass[corner] * sums[corner] / own;
    }
    const double across = stiffness_across(triangles[t], q) * w.maxCoeff();
    const Eigen::Matrix3d by_mass = squared_derivatives(q, w);
    if (4 * (triangles[t].stretch * by_mass).trace() + across <= omega2) continue;
    omega2 = std::max(omega2, 4 * largest_product(triangles[t].stretch, by_mass) + across);
  }
  for (double& bound : bounds) bound = std::sqrt(bound);
  return bounds;
}

}  // namespace clothsim
