// Bends that are curved at rest.

#include <Eigen/LU>
#include <cmath>

#include "clothsim/dynamics/bend_rotation.h"
#include "clothsim/dynamics/drag.h"
#include "clothsim/dynamics/xpbd.h"
#include "clothsim/model/smooth_normal.h"
#include "colouring.h"

namespace clothsim {
namespace {

std::array<Eigen::Matrix3d, PatchBend::near> derivatives_of(const PatchBend& bend,
                                                            const SmoothNormal& normal) {
  std::array<Eigen::Matrix3d, PatchBend::near> all;
  for (std::size_t k = 0; k < all.size(); ++k) {
    all[k] = bend.coefficients[k] * Eigen::Matrix3d::Identity();
    if (k < 3) all[k] -= bend.curvature * normal.derivative(k);
  }
  return all;
}

}  // namespace

void Xpbd::build_curved(const Cloth& cloth, double h) {
  curved_ = {};
  if (!cloth.is_mesh()) return;
  Colouring<CurvedConstraint> colouring(cloth);
  for (const PatchBend& bend : cloth.triangle_fabric->bends) {
    if (bend.curvature == 0) continue;
    const double compliance = 1 / (bend.stiffness * free_step_time2(cloth, bend.points[0], h));
    const double tau = cloth.internal_damping_at(bend.points[0])[1];
    const Vector3 none = Vector3::Zero();
    Derivatives unset;
    unset.fill(Eigen::Matrix3d::Zero());
    colouring.add({bend, compliance, none, compliance * h / tau, none, unset, none}, bend.points);
  }
  colouring.move_to(curved_.list, curved_.colour_ends);
}

void Xpbd::set_curved_frames() {
  for (CurvedConstraint& c : curved_.list) {
    c.at_frame = derivatives_of(c.bend, SmoothNormal(c.bend, frame_));
  }
}

void Xpbd::set_curved_targets() {
  for (CurvedConstraint& c : curved_.list) {
    c.target.setZero();
    for (std::size_t k = 0; k < c.at_frame.size(); ++k) {
      c.target += c.at_frame[k] * row(turned_, c.bend.points[k]);
    }
  }
}

/// As for other bends, with a matrix for 1 / share.
void Xpbd::solve_curved(const Cloth& cloth, const PatchBend& bend, const Derivatives& derivatives,
                        const Vector3& residual, double compliance, Vector3& lambda,
                        Points& positions) {
  const auto& points = bend.points;
  Eigen::Matrix3d matrix = compliance * Eigen::Matrix3d::Identity();
  for (std::size_t k = 0; k < derivatives.size(); ++k) {
    for (std::size_t l = 0; l < derivatives.size(); ++l) {
      if (points[k] != points[l]) continue;
      matrix += cloth.inv_mass[points[k]] * derivatives[k] * derivatives[l].transpose();
    }
  }
  const Vector3 change = matrix.inverse() * (-residual - compliance * lambda);
  lambda += change;
  for (std::size_t k = 0; k < derivatives.size(); ++k) {
    const Eigen::RowVector3d correction = change.transpose() * derivatives[k];
    positions.row(points[k]) += cloth.inv_mass[points[k]] * correction;
    react(cloth, points[k], correction);
  }
}

void Xpbd::solve_curved(const Cloth& cloth, bool back, Points& positions, const Workers& workers) {
  parallel_for_colours(curved_.colour_ends, back, workers, [&](std::size_t id) {
    CurvedConstraint& c = curved_.list[id];
    const SmoothNormal normal(c.bend, positions);
    const Vector3 deviation = c.bend.of(positions) - c.bend.curvature * normal.normal();
    solve_curved(cloth, c.bend, derivatives_of(c.bend, normal), deviation, c.compliance, c.lambda,
                 positions);
    if (!c.is_damped()) return;
    Vector3 residual = -c.target;
    for (std::size_t k = 0; k < c.at_frame.size(); ++k) {
      residual += c.at_frame[k] * row(positions, c.bend.points[k]);
    }
    solve_curved(cloth, c.bend, c.at_frame, residual, c.damping_compliance, c.damping_lambda,
                 positions);
  });
}

/// For the stiffness against turning see add_curved_sums().
void Xpbd::pull_by_curved(const Cloth& cloth, const Points& positions) {
  for (const CurvedConstraint& c : curved_.list) {
    const SmoothNormal normal(c.bend, positions);
    const Derivatives derivatives = derivatives_of(c.bend, normal);
    for (std::size_t k = 0; k < derivatives.size(); ++k) {
      pull(cloth, c.bend.points[k], c.lambda.transpose() * derivatives[k]);
      if (!c.is_damped()) continue;
      pull(cloth, c.bend.points[k], c.damping_lambda.transpose() * c.at_frame[k]);
    }
    const double slopes = normal.slope(0) + normal.slope(1) + normal.slope(2);
    for (std::size_t k = 0; k < 3; ++k) {
      turn_[c.bend.points[k]] += 5 * cloth.inv_mass[c.bend.points[k]] * std::abs(c.bend.curvature) *
                                 c.lambda.norm() * normal.slope(k) * slopes;
    }
  }
}

}  // namespace clothsim
