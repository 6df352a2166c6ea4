#include "clothsim/dynamics/newton_solver.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "clothsim/dynamics/bends.h"
#include "clothsim/dynamics/cells.h"
#include "clothsim/dynamics/hessian.h"
#include "clothsim/dynamics/incremental_potential.h"
#include "clothsim/dynamics/spring_system.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/triangle_forces.h"
#include "clothsim/model/smooth_normal.h"

namespace clothsim {
namespace {

/// Shortest step tried, of Newton's. Below it is lost in rounding.
constexpr double shortest_step = std::numeric_limits<double>::epsilon();

/// Errors of a step that do not count, of the tolerance.
constexpr double step_precision = 0.01;

/// Longest spring [m], or with bends alone the distance of two neighbours.
double longest_link(const Cloth& cloth) {
  if (!cloth.springs.empty()) return longest_rest_length(cloth);
  const BendRun& run = cloth.bends.front();
  return (cloth.rest_positions.row(run.first + run.a) - cloth.rest_positions.row(run.first)).norm();
}

/// A symmetric matrix with eigenvalues of at least `least`.
Eigen::Matrix2d clamped(const Eigen::Matrix2d& matrix, double least) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  solver.computeDirect(matrix);
  const Eigen::Matrix2d& vectors = solver.eigenvectors();
  return vectors * solver.eigenvalues().cwiseMax(least).asDiagonal() * vectors.transpose();
}

/// Number of the first cell's first pair in SpringSystem.
int first_cell_pair(const Cloth& cloth) {
  int id = cloth.num_springs();
  for_each_bent_pair(cloth, [&](double, int, int) { ++id; });
  return id;
}

}  // namespace

struct NewtonSolver::Impl {
  explicit Impl(const Parameters& p) : parameters(p) {}

  int solve(const Cloth& cloth, const Scalars& weights, const Points& y, const Past& past,
            Points& d);
  void share_inertia(const Cloth& cloth, const Scalars& weights);
  bool find_step(const Cloth& cloth, const Past& past, double small);
  void keep_momentum();
  double bearable(int a, int b) const { return 1 / (1 / spare[a] + 1 / spare[b]); }
  void add_springs(const Cloth& cloth, const Past& past);
  void add_cells(const Cloth& cloth, const Past& past);
  void add_triangles(const Cloth& cloth, const Past& past);
  void add_bends(const Cloth& cloth, const Past& past);
  void add_curved(const Cloth& cloth, const Past& past);
  void add_between(const Cloth& cloth, int id, int a, int b, const Eigen::Matrix3d& block);
  bool descend(const Cloth& cloth, const Scalars& weights, const Points& y, const Past& past,
               Points& d);

  Parameters parameters;
  bool unconverged = false;
  SpringSystem system;
  Scalars inertia;   // `weights` of free points [N/m], 0 at pins
  Scalars spare;     // inertia available to each spring of a point [N/m], infinite at pins
  Points positions;  // y + d [m]
  Points gradient;   // of the potential [N]
  Points step;       // Newton's [m]
  Points trial;      // [m]
};

/// A compressed spring has a stiffness -s across itself. Two ends of inertia p and q keep the
/// matrix positive definite for s < p q / (p + q). Here p and q are equal shares of the inertia of
/// each point, one for each of its springs and strains of cells, and one that the point keeps.
void NewtonSolver::Impl::share_inertia(const Cloth& cloth, const Scalars& weights) {
  Scalars springs = Scalars::Zero(cloth.num_points());
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    if (run.stiffness == 0) return;
    ++springs[a];
    ++springs[b];
  });
  for_each_cell(cloth, [&](const Cell& cell) {
    for (const int corner : cell.corners) ++springs[corner];
  });
  const auto is_free = cloth.inv_mass.array() > 0;
  spare = is_free.select(weights.array() / (springs.array() + 1), infinity);
  inertia = is_free.select(weights, 0);
}

/// Adds `block` to both points, -`block` between them, except for pins.
void NewtonSolver::Impl::add_between(const Cloth& cloth, int id, int a, int b,
                                     const Eigen::Matrix3d& block) {
  const bool free_a = cloth.inv_mass[a] > 0;
  const bool free_b = cloth.inv_mass[b] > 0;
  if (free_a && free_b) {
    system.add_pair(id, a, b, block);
  } else if (free_a || free_b) {
    system.add_to_point(free_a ? a : b, block);
  }
}

void NewtonSolver::Impl::add_springs(const Cloth& cloth, const Past& past) {
  int id = 0;
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const Vector3 between = positions.row(b) - positions.row(a);
    DampedSpring spring{run.stiffness, run.rest_length};
    if (!past.empty()) {
      spring = damped(run, cloth.internal_damping[0], past.lengths[static_cast<std::size_t>(id)],
                      past.time);
    }
    // The share of the ends' inertia for each spring permits some negative stiffness across it.
    const double min_across = spring.stiffness > 0 ? -bearable(a, b) / spring.stiffness : 0;
    add_between(cloth, id, a, b,
                spring_hessian(spring.stiffness, spring.rest_length, between, min_across));
    ++id;
  });
}

/// The Hessian of a cell's strain, of derivatives g and stress s: k g g^T, and s times the second
/// derivatives of the strain, which may be negative as far as the corners bear it.
void NewtonSolver::Impl::add_cells(const Cloth& cloth, const Past& past) {
  std::size_t number = 0;
  int id = first_cell_pair(cloth);
  for_each_cell(cloth, [&](const Cell& cell) {
    double strain = cell.value(positions), stiffness = cell.stiffness;
    if (!past.empty()) {
      const double share = cloth.internal_damping[0] / past.time;
      strain = (strain + share * (strain - past.strains[number++])) / (1 + share);
      stiffness *= 1 + share;
    }
    const auto& [p, q, r, rest] = cell.strain;
    const Cell::Diagonals by = cell.gradients(positions);
    const double most = std::min(bearable(cell.corners[0], cell.corners[3]),
                                 bearable(cell.corners[1], cell.corners[2]));
    const Eigen::Matrix2d across =
        clamped(stiffness * strain * (Eigen::Matrix2d() << 2 * p, r, r, 2 * q).finished(), -most);
    const auto block = [&](std::size_t k, std::size_t l) {  // rows of corner k, columns of l
      const std::size_t d = Cell::diagonal_of(k), e = Cell::diagonal_of(l);
      Eigen::Matrix3d sum = stiffness * by[d] * by[e].transpose();
      sum.diagonal().array() += across(static_cast<Eigen::Index>(d), static_cast<Eigen::Index>(e));
      return Eigen::Matrix3d(Cell::sign(k) * Cell::sign(l) * sum);
    };
    for (std::size_t l = 0; l < 4; ++l) {
      const int b = cell.corners[l];
      if (cloth.inv_mass[b] > 0) system.add_to_point(b, block(l, l));
      for (std::size_t k = 0; k < l; ++k, ++id) {
        const int a = cell.corners[k];
        if (cloth.inv_mass[a] > 0 && cloth.inv_mass[b] > 0) system.add_between(id, a, block(l, k));
      }
    }
  });
}

/// The Hessian of a triangle: 4 J K J^T, with the columns J of half the derivatives of q, and a
/// stiffness 2 s across each edge, which an edge of two triangles bears half of from each.
void NewtonSolver::Impl::add_triangles(const Cloth& cloth, const Past& past) {
  for (std::size_t t = 0; t < cloth.triangles.size(); ++t) {
    const std::array<int, 3>& corners = cloth.triangles[t];
    const double share = past.empty() ? 0 : cloth.internal_damping_at(corners[0])[0] / past.time;
    const TriangleFabric::Triangle& triangle = cloth.triangle_fabric->triangles[t];
    const Vector3 q = squared_edges(corners, positions);
    Vector3 change = q - triangle.rest2;
    Eigen::Matrix<double, 9, 3> j = Eigen::Matrix<double, 9, 3>::Zero();
    for (Eigen::Index k = 0; k < 3; ++k) {
      const int a = corners[static_cast<std::size_t>(k)];
      const int b = corners[static_cast<std::size_t>((k + 1) % 3)];
      const Vector3 d = row(positions, b) - row(positions, a);
      j.block<3, 1>(3 * k, k) = -d;
      j.block<3, 1>(3 * ((k + 1) % 3), k) = d;
      if (past.empty()) continue;
      const int edge = triangle.edges[static_cast<std::size_t>(k)];
      change[k] += share * (q[k] - past.squares[static_cast<std::size_t>(edge)]);
    }
    Eigen::Matrix<double, 9, 9> hessian = 4 * (1 + share) * j * triangle.stretch * j.transpose();
    const Vector3 pulls = triangle.stretch * change;
    for (Eigen::Index k = 0; k < 3; ++k) {
      const Eigen::Index l = (k + 1) % 3;
      const double most =
          bearable(corners[static_cast<std::size_t>(k)], corners[static_cast<std::size_t>(l)]) / 2;
      const Eigen::Matrix3d across = std::max(2 * pulls[k], -most) * Eigen::Matrix3d::Identity();
      hessian.block<3, 3>(3 * k, 3 * k) += across;
      hessian.block<3, 3>(3 * l, 3 * l) += across;
      hessian.block<3, 3>(3 * k, 3 * l) -= across;
      hessian.block<3, 3>(3 * l, 3 * k) -= across;
    }
    for (Eigen::Index k = 0; k < 3; ++k) {
      const Eigen::Index l = (k + 1) % 3;
      const int a = corners[static_cast<std::size_t>(k)], b = corners[static_cast<std::size_t>(l)];
      if (cloth.inv_mass[a] > 0) system.add_to_point(a, hessian.block<3, 3>(3 * k, 3 * k));
      if (cloth.inv_mass[a] == 0 || cloth.inv_mass[b] == 0) continue;
      const int id = triangle.edges[static_cast<std::size_t>(k)];
      const auto block =
          a < b ? hessian.block<3, 3>(3 * l, 3 * k) : hessian.block<3, 3>(3 * k, 3 * l);
      system.add_between(id, std::min(a, b), block);
    }
  }
}

/// Their pairs follow the springs. Some are negative, but all together are positive semidefinite.
/// The rotation of damping, of rank 3, is left out: with a matrix too stiff there the method
/// converges.
void NewtonSolver::Impl::add_bends(const Cloth& cloth, const Past& past) {
  int id = cloth.num_springs();
  for_each_bent_pair(cloth, [&](double w, int a, int b) {
    const double share = past.empty() ? 0 : cloth.internal_damping_at(a)[1] / past.time;
    add_between(cloth, id, a, b, w * (1 + share) * Eigen::Matrix3d::Identity());
    ++id;
  });
}

/// The part of CurvedTriangle in J^T k J, with J the derivatives of b - B n: the rest of J^T k J is
/// that of the pairs. The second derivative of n, which vanishes at rest, is left out, so that all
/// stays positive semidefinite. For damping J is that of the end, not of Past::frame.
void NewtonSolver::Impl::add_curved(const Cloth& cloth, const Past& past) {
  for (const CurvedTriangle& curved : cloth.triangle_fabric->curved) {
    const double share =
        past.empty() ? 0 : cloth.internal_damping_at(curved.points[0])[1] / past.time;
    const SmoothNormal normal(curved, positions);
    std::array<Eigen::Matrix3d, 3> turns;
    for (std::size_t k = 0; k < 3; ++k) turns[k] = normal.derivative(k);
    std::size_t pair = 0;
    for (std::size_t k = 0; k < PatchBend::near; ++k) {
      for (std::size_t l = k; l < PatchBend::near; ++l) {
        const int number = l > k ? curved.pairs[pair++] : -1;
        const int a = curved.points[k], b = curved.points[l];
        if (cloth.inv_mass[a] == 0 || cloth.inv_mass[b] == 0) continue;
        Eigen::Matrix3d block = Eigen::Matrix3d::Zero();  // rows of a, columns of b
        if (l < 3) block -= curved.weights[k] * turns[l];
        if (k < 3) block -= curved.weights[l] * turns[k].transpose();
        if (l < 3) block += curved.stiffness * turns[k].transpose() * turns[l];
        block *= 1 + share;
        if (number >= 0) {
          const int id = cloth.num_springs() + number;
          system.add_between(id, std::min(a, b),
                             a < b ? Eigen::Matrix3d(block.transpose()) : block);
        } else {
          system.add_to_point(a, l > k ? Eigen::Matrix3d(block + block.transpose()) : block);
        }
      }
    }
  }
}

/// Newton's step from `positions` and `gradient`, at least to some hundredth of a `small` step [m].
/// False where there is none.
bool NewtonSolver::Impl::find_step(const Cloth& cloth, const Past& past, double small) {
  system.begin(cloth);
  for (int i = 0; i < cloth.num_points(); ++i) {
    system.add_to_point(i, (inertia[i] > 0 ? inertia[i] : 1) * Eigen::Matrix3d::Identity());
  }
  if (cloth.is_mesh()) {
    add_triangles(cloth, past);
  } else {
    add_springs(cloth, past);
    add_cells(cloth, past);
  }
  add_bends(cloth, past);
  if (cloth.is_mesh()) add_curved(cloth, past);
  // A point of inertia w that is off by e has an energy of w e^2.
  const double lightest = (inertia.array() > 0).select(inertia, infinity).minCoeff();
  if (!system.solve(-gradient, lightest * std::pow(step_precision * small, 2), step)) return false;
  keep_momentum();
  return true;
}

/// Shifts each piece of cloth without pins so that the sum of inertia times displacement stays
/// zero: an inexact solution does not keep the sum by itself.
void NewtonSolver::Impl::keep_momentum() {
  const std::vector<int>& points = system.points();
  for (const SpringSystem::Piece& piece : system.pieces()) {
    Vector3 sum = Vector3::Zero();  // of the displacement so far, and of the step
    double all = 0;
    bool is_free = true;
    for (int r = piece.begin; r < piece.end; ++r) {
      const int i = points[static_cast<std::size_t>(r)];
      sum += inertia[i] * row(step, i) + row(gradient, i);
      all += inertia[i];
      is_free = is_free && inertia[i] > 0;
    }
    if (!is_free) continue;
    for (int r = piece.begin; r < piece.end; ++r) {
      step.row(points[static_cast<std::size_t>(r)]) -= sum.transpose() / all;
    }
  }
}

/// Takes the largest of the shares 1, 1/2, 1/4 .. of `step` that lowers the potential. False where
/// none does.
bool NewtonSolver::Impl::descend(const Cloth& cloth, const Scalars& weights, const Points& y,
                                 const Past& past, Points& d) {
  const double before = incremental_potential(cloth, weights, y, d, past);
  const double rounding = 1e-13 * before;
  for (double share = 1; share >= shortest_step; share /= 2) {
    trial = d + share * step;
    const double after = incremental_potential(cloth, weights, y, trial, past);
    if (after <= before + rounding) {
      std::swap(d, trial);
      return true;
    }
  }
  return false;
}

int NewtonSolver::Impl::solve(const Cloth& cloth, const Scalars& weights, const Points& y,
                              const Past& past, Points& d) {
  d.setZero(cloth.num_points(), 3);
  unconverged = false;
  if (!cloth.has_forces()) return 0;

  share_inertia(cloth, weights);
  gradient.resize(cloth.num_points(), 3);
  const double small = parameters.tolerance * longest_link(cloth);
  for (int iteration = 1; iteration <= parameters.max_iterations; ++iteration) {
    positions = y + d;
    potential_gradient(cloth, weights, positions, d, gradient, past);
    if (!find_step(cloth, past, small)) {
      d.setConstant(std::numeric_limits<double>::quiet_NaN());
      return iteration;
    }
    if (step.cwiseAbs().maxCoeff() <= small) {
      d += step;
      return iteration;
    }
    if (!descend(cloth, weights, y, past, d)) {
      unconverged = true;
      return iteration;
    }
  }
  unconverged = true;
  return parameters.max_iterations;
}

NewtonSolver::NewtonSolver(const Parameters& parameters)
    : impl_(std::make_unique<Impl>(parameters)) {}
NewtonSolver::~NewtonSolver() = default;
NewtonSolver::NewtonSolver(NewtonSolver&&) noexcept = default;
NewtonSolver& NewtonSolver::operator=(NewtonSolver&&) noexcept = default;

int NewtonSolver::solve(const Cloth& cloth, const Scalars& weights, const Points& y, Points& d,
                        const Past& past) {
  return impl_->solve(cloth, weights, y, past, d);
}

bool NewtonSolver::unconverged() const { return impl_->unconverged; }

}  // namespace clothsim
