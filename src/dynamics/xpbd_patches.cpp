// Bends of a mesh that are flat at rest.

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <vector>

#include "clothsim/dynamics/drag.h"
#include "clothsim/dynamics/xpbd.h"
#include "colouring.h"

namespace clothsim {
namespace {

template <std::size_t size>
Eigen::Matrix<double, static_cast<int>(size), 3> rows_of(const Points& values,
                                                         const std::array<int, size>& points) {
  Eigen::Matrix<double, static_cast<int>(size), 3> rows;
  for (std::size_t k = 0; k < size; ++k) {
    rows.row(static_cast<Eigen::Index>(k)) = values.row(points[k]);
  }
  return rows;
}

/// C w C^T. Neighbours may share a point.
template <std::size_t size, typename Coefficients>
Eigen::Matrix3d inverse_masses(const Cloth& cloth, const std::array<int, size>& points,
                               const Coefficients& coefficients) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < size; ++k) {
    for (std::size_t l = 0; l < size; ++l) {
      if (points[k] != points[l]) continue;
      const Vector3 one = coefficients.col(static_cast<Eigen::Index>(k)),
                    other = coefficients.col(static_cast<Eigen::Index>(l));
      sum += cloth.inv_mass[points[k]] * one * other.transpose();
    }
  }
  return sum;
}

/// One past the last of the bends from `first` on that have the same points.
std::size_t next_triangle(const std::vector<PatchBend>& bends, std::size_t first) {
  std::size_t next = first;
  while (next < bends.size() && bends[next].points == bends[first].points) ++next;
  return next;
}

bool has_many_points(const PatchBend& bend) {
  const auto is_used = [](double coefficient) { return coefficient != 0; };
  return std::any_of(bend.coefficients.begin() + PatchBend::near, bend.coefficients.end(), is_used);
}

}  // namespace

void Xpbd::build_patches(const Cloth& cloth, double h) {
  patches_ = {};
  if (!cloth.is_mesh()) return;
  const std::vector<PatchBend>& bends = cloth.triangle_fabric->bends;
  for_each_size(patches_, [&](auto& patches) {
    using Constraint = typename std::decay_t<decltype(patches.list)>::value_type;
    constexpr std::size_t size = std::tuple_size_v<decltype(Constraint::points)>;
    Colouring<Constraint> colouring(cloth);
    for (std::size_t first = 0, next; first < bends.size(); first = next) {
      next = next_triangle(bends, first);
      const bool is_wide =
          std::any_of(&bends[first], &bends[first] + (next - first), has_many_points);
      if (is_wide != (size == PatchBend::size)) continue;
      Constraint c{};
      std::copy_n(bends[first].points.begin(), size, c.points.begin());
      const double damped = 1 + cloth.internal_damping_at(c.points[0])[1] / h;
      const double time2 = free_step_time2(cloth, c.points[0], h);
      c.coefficients.setZero();
      c.compliance.setZero();
      Vector3 diagonal = Vector3::Ones();  // in rows without a bend
      Eigen::Index row = 0;
      for (std::size_t b = first; b < next; ++b) {
        if (bends[b].curvature != 0) continue;
        for (std::size_t k = 0; k < size; ++k) {
          c.coefficients(row, static_cast<Eigen::Index>(k)) = bends[b].coefficients[k];
        }
        diagonal[row] = c.compliance[row] = 1 / (bends[b].stiffness * damped * time2);
        ++row;
      }
      if (row == 0) continue;
      c.inverse = inverse_masses(cloth, c.points, c.coefficients);
      c.inverse.diagonal() += diagonal;
      c.inverse = c.inverse.inverse().eval();
      c.target.setZero();
      c.lambda.setZero();
      colouring.add(c, c.points);
    }
    colouring.move_to(patches.list, patches.colour_ends);
  });
}

void Xpbd::set_patch_targets(const Cloth& cloth, double h) {
  for_each_size(patches_, [&](auto& patches) {
    for (auto& c : patches.list) {
      const double share = cloth.internal_damping_at(c.points[0])[1] / h;
      c.target = share / (1 + share) * (c.coefficients * rows_of(turned_, c.points));
    }
  });
}

template <typename Patches>
void Xpbd::solve_patches(const Cloth& cloth, bool back, Patches& patches, Points& positions,
                         const Workers& workers) {
  parallel_for_colours(patches.colour_ends, back, workers, [&](std::size_t id) {
    auto& c = patches.list[id];
    const Eigen::Matrix3d change =
        c.inverse * (c.target - c.coefficients * rows_of(positions, c.points) -
                     c.compliance.asDiagonal() * c.lambda);
    c.lambda += change;
    const decltype(rows_of(positions, c.points)) corrections = c.coefficients.transpose() * change;
    for (std::size_t k = 0; k < c.points.size(); ++k) {
      const Eigen::RowVector3d correction = corrections.row(static_cast<Eigen::Index>(k));
      positions.row(c.points[k]) += cloth.inv_mass[c.points[k]] * correction;
      react(cloth, c.points[k], correction);
    }
  });
}

void Xpbd::solve_patches(const Cloth& cloth, bool back, Points& positions, const Workers& workers) {
  auto& [near, wide] = patches_;
  if (back) solve_patches(cloth, back, wide, positions, workers);
  solve_patches(cloth, back, near, positions, workers);
  if (!back) solve_patches(cloth, back, wide, positions, workers);
}

void Xpbd::pull_by_patches(const Cloth& cloth) {
  for_each_size(patches_, [&](const auto& patches) {
    for (const auto& c : patches.list) {
      for (std::size_t k = 0; k < c.points.size(); ++k) {
        pull(cloth, c.points[k],
             c.coefficients.col(static_cast<Eigen::Index>(k)).transpose() * c.lambda);
      }
    }
  });
}

}  // namespace clothsim
