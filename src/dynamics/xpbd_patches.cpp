// Bends of a mesh that are flat at rest.

#include <Eigen/LU>

#include "clothsim/dynamics/drag.h"
#include "clothsim/dynamics/xpbd.h"
#include "colouring.h"

namespace clothsim {
namespace {

using Coefficients = Eigen::Matrix<double, 3, PatchBend::size>;
using Rows = Eigen::Matrix<double, PatchBend::size, 3>;

Rows rows_of(const Points& values, const std::array<int, PatchBend::size>& points) {
  Rows rows;
  for (std::size_t k = 0; k < points.size(); ++k) {
    rows.row(static_cast<Eigen::Index>(k)) = values.row(points[k]);
  }
  return rows;
}

/// C w C^T. Neighbours may share a point.
Eigen::Matrix3d inverse_masses(const Cloth& cloth, const std::array<int, PatchBend::size>& points,
                               const Coefficients& coefficients) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < points.size(); ++k) {
    for (std::size_t l = 0; l < points.size(); ++l) {
      if (points[k] != points[l]) continue;
      const Vector3 one = coefficients.col(static_cast<Eigen::Index>(k)),
                    other = coefficients.col(static_cast<Eigen::Index>(l));
      sum += cloth.inv_mass[points[k]] * one * other.transpose();
    }
  }
  return sum;
}

}  // namespace

void Xpbd::build_patches(const Cloth& cloth, double h) {
  patches_ = {};
  if (!cloth.is_mesh()) return;
  Colouring<PatchConstraint> colouring(cloth);
  const std::vector<PatchBend>& bends = cloth.triangle_fabric->bends;
  for (std::size_t first = 0, next; first < bends.size(); first = next) {
    PatchConstraint c{bends[first].points,     Coefficients::Zero(),    Vector3::Zero(),
                      Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()};
    const double damped = 1 + cloth.internal_damping_at(c.points[0])[1] / h;
    const double time2 = free_step_time2(cloth, c.points[0], h);
    Vector3 diagonal = Vector3::Ones();  // in rows without a bend
    Eigen::Index row = 0;
    for (next = first; next < bends.size() && bends[next].points == c.points; ++next) {
      if (bends[next].curvature != 0) continue;
      for (std::size_t k = 0; k < c.points.size(); ++k) {
        c.coefficients(row, static_cast<Eigen::Index>(k)) = bends[next].coefficients[k];
      }
      diagonal[row] = c.compliance[row] = 1 / (bends[next].stiffness * damped * time2);
      ++row;
    }
    if (row == 0) continue;
    c.inverse = inverse_masses(cloth, c.points, c.coefficients);
    c.inverse.diagonal() += diagonal;
    c.inverse = c.inverse.inverse().eval();
    colouring.add(c, c.points);
  }
  colouring.move_to(patches_.list, patches_.colour_ends);
}

void Xpbd::set_patch_targets(const Cloth& cloth, double h) {
  for (PatchConstraint& c : patches_.list) {
    const double share = cloth.internal_damping_at(c.points[0])[1] / h;
    c.target = share / (1 + share) * (c.coefficients * rows_of(turned_, c.points));
  }
}

void Xpbd::solve_patches(const Cloth& cloth, bool back, Points& positions, const Workers& workers) {
  parallel_for_colours(patches_.colour_ends, back, workers, [&](std::size_t id) {
    PatchConstraint& c = patches_.list[id];
    const Eigen::Matrix3d change =
        c.inverse * (c.target - c.coefficients * rows_of(positions, c.points) -
                     c.compliance.asDiagonal() * c.lambda);
    c.lambda += change;
    const Rows corrections = c.coefficients.transpose() * change;
    for (std::size_t k = 0; k < c.points.size(); ++k) {
      const Eigen::RowVector3d correction = corrections.row(static_cast<Eigen::Index>(k));
      positions.row(c.points[k]) += cloth.inv_mass[c.points[k]] * correction;
      react(cloth, c.points[k], correction);
    }
  });
}

void Xpbd::pull_by_patches(const Cloth& cloth) {
  for (const PatchConstraint& c : patches_.list) {
    const Rows corrections = c.coefficients.transpose() * c.lambda;
    for (std::size_t k = 0; k < c.points.size(); ++k) {
      pull(cloth, c.points[k], corrections.row(static_cast<Eigen::Index>(k)));
    }
  }
}

}  // namespace clothsim
