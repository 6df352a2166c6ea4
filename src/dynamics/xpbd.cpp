#include "clothsim/dynamics/xpbd.h"

#include <Eigen/LU>
#include <array>
#include <cmath>

#include "clothsim/dynamics/bend_rotation.h"
#include "clothsim/dynamics/drag.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/triangle_forces.h"
#include "colouring.h"

namespace clothsim {

void Xpbd::build(const Cloth& cloth, double h) {
  if (cloth.is_mesh()) {
    springs_.clear();
    build_membranes(cloth, h);
  } else {
    membranes_ = {};
    springs_.build(cloth, h);
  }
  build_cells(cloth, h);
  build_bends(cloth, h);
  build_patches(cloth, h);
  build_curved(cloth, h);
}

void Xpbd::build_membranes(const Cloth& cloth, double h) {
  Colouring<MembraneConstraint> colouring(cloth);
  for (std::size_t t = 0; t < cloth.triangles.size(); ++t) {
    const TriangleFabric::Triangle& triangle = cloth.triangle_fabric->triangles[t];
    const double damped = 1 + cloth.internal_damping_at(cloth.triangles[t][0])[0] / h;
    const double time2 = free_step_time2(cloth, cloth.triangles[t][0], h);
    colouring.add({cloth.triangles[t], triangle.rest2, damped * time2 * triangle.stretch,
                   triangle.rest2, Vector3::Zero()},
                  cloth.triangles[t]);
  }
  colouring.move_to(membranes_.list, membranes_.colour_ends);
}

void Xpbd::build_cells(const Cloth& cloth, double h) {
  const double time2 = h * Drag(cloth.damping, h).distance;
  const double damped = 1 + cloth.internal_damping[0] / h;
  Colouring<CellConstraint> colouring(cloth);
  for_each_cell(cloth, [&](const Cell& cell) {
    colouring.add({cell, 1 / (cell.stiffness * damped * time2), 0, 0}, cell.corners);
  });
  colouring.move_to(cells_.list, cells_.colour_ends);
}

void Xpbd::build_bends(const Cloth& cloth, double h) {
  bends_ = {};
  if (cloth.is_mesh()) return;
  const double time2 = h * Drag(cloth.damping, h).distance;
  const double damped = 1 + cloth.internal_damping[1] / h;
  Colouring<BendConstraint> colouring(cloth);
  for_each_bend(cloth, [&](const auto& bend) {
    if constexpr (std::is_same_v<std::decay_t<decltype(bend)>, Bend>) {
      double inv_mass = 0;
      for (std::size_t k = 0; k < bend.points.size(); ++k) {
        for (std::size_t l = 0; l < bend.points.size(); ++l) {  // the middle may be one
          if (bend.points[k] != bend.points[l]) continue;
          inv_mass += cloth.inv_mass[bend.points[k]] * bend.coefficient(k) * bend.coefficient(l);
        }
      }
      const double compliance = 1 / (bend.stiffness * damped * time2);
      colouring.add(
          {bend, compliance, 1 / (inv_mass + compliance), Vector3::Zero(), Vector3::Zero()},
          bend.points);
    }
  });
  colouring.move_to(bends_.list, bends_.colour_ends);
}

/// Sets the targets of constraints in a step from `positions`, between their rest values and the
/// present ones.
void Xpbd::set_targets(const Cloth& cloth, double h, const Points& positions) {
  const double of_springs = cloth.internal_damping[0];
  springs_.set_targets(positions, of_springs, h);
  for (CellConstraint& c : cells_.list) {
    c.target = of_springs / h * c.cell.value(positions) / (1 + of_springs / h);
  }
  for (MembraneConstraint& c : membranes_.list) {
    const double share = cloth.internal_damping_at(c.corners[0])[0] / h;
    c.target = (c.rest2 + share * squared_edges(c.corners, positions)) / (1 + share);
  }
}

/// The same for bends, which turn as points do that move by `displacements`: see Past.
void Xpbd::set_bend_targets(const Cloth& cloth, double h, const Points& displacements,
                            const Workers& workers) {
  remove_rotation(cloth, frame_, displacements, turned_, workers);
  turned_ = past_ + displacements - turned_;
  const double share = cloth.internal_damping[1] / h;
  for (BendConstraint& c : bends_.list) c.target = share / (1 + share) * c.bend.of(turned_);
  set_patch_targets(cloth, h);
  set_curved_targets();
}

void Xpbd::solve_cells(const Cloth& cloth, bool back, Points& positions, const Workers& workers) {
  parallel_for_colours(cells_.colour_ends, back, workers, [&](std::size_t id) {
    CellConstraint& c = cells_.list[id];
    const Cell::Diagonals by = c.cell.gradients(positions);
    double inv_mass = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      inv_mass += cloth.inv_mass[c.cell.corners[k]] * by[Cell::diagonal_of(k)].squaredNorm();
    }
    const double change =
        (c.target - c.cell.value(positions) - c.compliance * c.lambda) / (inv_mass + c.compliance);
    c.lambda += change;
    for (std::size_t k = 0; k < 4; ++k) {
      const int i = c.cell.corners[k];
      const Eigen::RowVector3d correction =
          change * Cell::sign(k) * by[Cell::diagonal_of(k)].transpose();
      positions.row(i) += cloth.inv_mass[i] * correction;
      react(cloth, i, correction);
    }
  });
}

/// A pass over triangles, each with its three squared lengths at once: multipliers change by
///   (I + h^2 K G)^-1 (-h^2 K (q - Q) - lambda),  G = 4 J^T w J
/// with J as in NewtonSolver: no inverse of K, which a fabric without shear stiffness lacks.
void Xpbd::solve_membranes(const Cloth& cloth, bool back, Points& positions,
                           const Workers& workers) {
  parallel_for_colours(membranes_.colour_ends, back, workers, [&](std::size_t id) {
    MembraneConstraint& c = membranes_.list[id];
    const Vector3 q = squared_edges(c.corners, positions);
    const auto& [i, j, k] = c.corners;
    const Vector3 w(cloth.inv_mass[i], cloth.inv_mass[j], cloth.inv_mass[k]);
    const Eigen::Matrix3d matrix =
        Eigen::Matrix3d::Identity() + 4 * c.stiffness * squared_derivatives(q, w);
    const Vector3 change = matrix.inverse() * (c.stiffness * (c.target - q) - c.lambda);
    c.lambda += change;
    std::array<Eigen::RowVector3d, 3> pulls;
    for (std::size_t e = 0; e < 3; ++e) {
      pulls[e] = 2 * change[static_cast<Eigen::Index>(e)] *
                 (positions.row(c.corners[(e + 1) % 3]) - positions.row(c.corners[e]));
    }
    for (std::size_t e = 0; e < 3; ++e) {
      const Eigen::RowVector3d& pull = pulls[e];
      const int a = c.corners[e], b = c.corners[(e + 1) % 3];
      positions.row(a) -= cloth.inv_mass[a] * pull;
      positions.row(b) += cloth.inv_mass[b] * pull;
      react(cloth, a, -pull);
      react(cloth, b, pull);
    }
  });
}

void Xpbd::solve_bends(const Cloth& cloth, bool back, Points& positions, const Workers& workers) {
  parallel_for_colours(bends_.colour_ends, back, workers, [&](std::size_t id) {
    BendConstraint& c = bends_.list[id];
    const Vector3 change = c.share * (c.target - c.bend.of(positions) - c.compliance * c.lambda);
    c.lambda += change;
    for (std::size_t k = 0; k < c.bend.points.size(); ++k) {
      const int i = c.bend.points[k];
      const Eigen::RowVector3d correction = c.bend.coefficient(k) * change.transpose();
      positions.row(i) += cloth.inv_mass[i] * correction;
      react(cloth, i, correction);
    }
  });
}

void Xpbd::pull(const Cloth& cloth, int i, const Eigen::RowVector3d& correction) {
  target_.row(i) += cloth.inv_mass[i] * correction;
  react(cloth, i, correction);
}

void Xpbd::pull_by_springs(const Cloth& cloth, const Points& positions) {
  springs_.for_each([&](int a, int b, double lambda) {
    const Vector3 d = row(positions, b) - row(positions, a);
    const double length = d.norm();
    if (length == 0) return;
    const double correction = lambda / length;
    pull(cloth, a, -correction * d.transpose());
    pull(cloth, b, correction * d.transpose());
    turn_[a] += 2 * cloth.inv_mass[a] * std::abs(correction);
    turn_[b] += 2 * cloth.inv_mass[b] * std::abs(correction);
  });
}

void Xpbd::pull_by_cells(const Cloth& cloth, const Points& positions) {
  for (const CellConstraint& c : cells_.list) {
    const Cell::Diagonals by = c.cell.gradients(positions);
    const CellStrain& strain = c.cell.strain;
    for (std::size_t k = 0; k < 4; ++k) {
      const int i = c.cell.corners[k];
      const std::size_t d = Cell::diagonal_of(k);
      pull(cloth, i, c.lambda * Cell::sign(k) * by[d].transpose());
      const double across = 2 * std::abs(d == 0 ? strain.p : strain.q) + std::abs(strain.r);
      turn_[i] += 2 * cloth.inv_mass[i] * std::abs(c.lambda) * across;
    }
  }
}

void Xpbd::pull_by_membranes(const Cloth& cloth, const Points& positions) {
  for (const MembraneConstraint& c : membranes_.list) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = c.corners[k], b = c.corners[(k + 1) % 3];
      const double lambda = 2 * c.lambda[static_cast<Eigen::Index>(k)];
      const Eigen::RowVector3d correction = lambda * (positions.row(b) - positions.row(a));
      pull(cloth, a, -correction);
      pull(cloth, b, correction);
      turn_[a] += 2 * cloth.inv_mass[a] * std::abs(lambda);
      turn_[b] += 2 * cloth.inv_mass[b] * std::abs(lambda);
    }
  }
}

void Xpbd::pull_by_bends(const Cloth& cloth) {
  for (const BendConstraint& c : bends_.list) {
    for (std::size_t k = 0; k < c.bend.points.size(); ++k) {
      pull(cloth, c.bend.points[k], c.bend.coefficient(k) * c.lambda.transpose());
    }
  }
}

/// With r the difference to start + w sum of lambda u, points move by r / (1 + 2 w sum of |lambda|
/// / l): a displacement across a spring of tension lambda turns its force by lambda / l of that,
/// and its other end may do the same. This converges however long the step.
void Xpbd::realign(const Cloth& cloth, Points& positions) {
  target_ = start_;
  reactions_.setZero();
  turn_.setOnes(cloth.num_points());
  pull_by_springs(cloth, positions);
  pull_by_cells(cloth, positions);
  pull_by_membranes(cloth, positions);
  pull_by_bends(cloth);
  pull_by_patches(cloth);
  pull_by_curved(cloth, positions);
  positions.array() += (target_ - positions).array().colwise() / turn_.array();
}

void Xpbd::add_reactions(const Cloth& cloth, double h, Points& impulses) const {
  for_each_damping(cloth, 0, cloth.num_points(), [&](int begin, int end, double damping) {
    impulses.middleRows(begin, end - begin) +=
        reactions_.middleRows(begin, end - begin) / Drag(damping, h).distance;
  });
}

void Xpbd::step(const Cloth& cloth, const Loads& loads, double h, State& state,
                const Workers& workers) {
  if (watch_.changed(cloth, h)) build(cloth, h);
  const bool has_targets = has_damped_bends(cloth);
  if (is_damped(cloth)) set_targets(cloth, h, state.positions);
  if (has_targets) {
    past_ = state.positions;
    frame_ = past_ + h / 2 * state.velocities;
    set_curved_frames();
    set_bend_targets(cloth, h, h * state.velocities, workers);
  }

  free_step(cloth, loads, h, state);
  start_ = state.positions;
  reactions_.setZero(cloth.num_points(), 3);
  springs_.begin_step();
  for (CellConstraint& c : cells_.list) c.lambda = 0;
  for (MembraneConstraint& c : membranes_.list) c.lambda.setZero();
  for (BendConstraint& c : bends_.list) c.lambda.setZero();
  for_each_size(patches_, [](auto& patches) {
    for (auto& c : patches.list) c.lambda.setZero();
  });
  for (CurvedConstraint& c : curved_.list) {
    c.lambda.setZero();
    c.damping_lambda.setZero();
  }
  for (int i = 0; i < parameters_.iterations; ++i) {
    if (i > 0) realign(cloth, state.positions);
    if (i > 0 && has_targets) set_bend_targets(cloth, h, state.positions - past_, workers);
    springs_.solve(false, state.positions, reactions_, workers);
    solve_cells(cloth, false, state.positions, workers);
    solve_membranes(cloth, false, state.positions, workers);
    for (const bool back : {false, true}) {
      solve_bends(cloth, back, state.positions, workers);
      solve_patches(cloth, back, state.positions, workers);
      solve_curved(cloth, back, state.positions, workers);
    }
    solve_membranes(cloth, true, state.positions, workers);
    solve_cells(cloth, true, state.positions, workers);
    springs_.solve(true, state.positions, reactions_, workers);
  }
  state.velocities += (state.positions - start_) / h;
}

}  // namespace clothsim
