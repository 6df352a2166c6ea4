#include "clothsim/dynamics/triangle_forces.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "clothsim/dynamics/bend_rotation.h"
#include "clothsim/dynamics/curved_bends.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// x, y, z of a point, and 0.
using Quad = double __attribute__((vector_size(32), aligned(8), may_alias));

/// Numbers that one computation of forces keeps between its loops. Its threads share them; calls
/// of different threads do not.
struct Scratch {
  explicit Scratch(const TriangleFabric& fabric) { fit(fabric); }
  void fit(const TriangleFabric& fabric) {
    const std::size_t points = fabric.first_links.size() - 1;
    const std::size_t links = std::max(fabric.edges.size(), fabric.pairs.size());
    positions.resize(4 * points);
    velocities.resize(4 * points);
    squares.resize(fabric.edges.size());
    pulls.resize(3 * fabric.triangles.size() + 1);
    factors.resize(links);
    weights.resize(links);
    bends.resize(4 * points);
    rates.resize(4 * points);
  }

  std::vector<double> positions, velocities;  // by point, a Quad each
  std::vector<double> squares;                // by edge: q + tau_0 q' [m^2]
  std::vector<double> pulls;                  // by triangle and edge, and a 0 [N/m]
  std::vector<double> factors;                // by link [N/m]
  std::vector<double> weights;                // of bends, times tau_1 [N s/m]
  std::vector<double> bends, rates;  // by point, a Quad each: sums of weight * (x_j - x_i) [N s],
                                     // and of weight * (v_j - v_i) [N]
};

Scratch& scratch_of(const TriangleFabric& fabric) {
  static thread_local Scratch scratch(fabric);
  scratch.fit(fabric);
  return scratch;
}

Quad* quads(std::vector<double>& numbers) { return reinterpret_cast<Quad*>(numbers.data()); }

void interleave(const Points& points, int begin, int end, double* quads) {
  for (int i = begin; i < end; ++i) {
    for (int axis = 0; axis < 3; ++axis) quads[4 * i + axis] = points(i, axis);
    quads[4 * i + 3] = 0;
  }
}

/// The parts of a kernel's input that all its loops share. `v` is null without damping.
struct QuadMotion {
  const Quad* x;
  const Quad* v;
};

double dot(const Quad& a, const Quad& b) {
  const Quad product = a * b;
  return product[0] + product[1] + product[2];
}

void square_edges(const TriangleFabric& fabric, const QuadMotion& at, int begin, int end,
                  double* squares) {
  for (int e = begin; e < end; ++e) {
    const auto& [a, b] = fabric.edges[static_cast<std::size_t>(e)];
    const Quad d = at.x[b] - at.x[a];
    squares[e] = dot(d, d);
    if (at.v == nullptr) continue;
    squares[e] += 2 * fabric.internal_damping_at(a)[0] * dot(d, at.v[b] - at.v[a]);
  }
}

void pull_triangles(const TriangleFabric& fabric, const double* squares, int begin, int end,
                    double* pulls) {
  for (int t = begin; t < end; ++t) {
    const TriangleFabric::Triangle& triangle = fabric.triangles[static_cast<std::size_t>(t)];
    const Vector3 change(squares[triangle.edges[0]] - triangle.rest2[0],
                         squares[triangle.edges[1]] - triangle.rest2[1],
                         squares[triangle.edges[2]] - triangle.rest2[2]);
    Eigen::Map<Vector3>(pulls + 3 * t).noalias() = triangle.stretch * change;
  }
}

/// Sums the links of points [begin, end), each of a force factor * (x_j - x_i). Where bends are
/// `damped`, also their sums for damping.
template <bool damped>
[[gnu::always_inline]] inline void sum_links_of(const TriangleFabric& fabric, const QuadMotion& at,
                                                int begin, int end, Scratch& scratch,
                                                Points& forces) {
  const double* const factors = scratch.factors.data();
  const double* const weights = scratch.weights.data();
  const TriangleFabric::Link* const links = fabric.links.data();
  for (int i = begin; i < end; ++i) {
    Quad sum = {}, bend = {}, rate = {};
    const int last = fabric.first_links[static_cast<std::size_t>(i) + 1];
    for (int l = fabric.first_links[static_cast<std::size_t>(i)]; l < last; ++l) {
      const auto& [j, number] = links[l];
      const Quad d = at.x[j] - at.x[i];
      sum += factors[number] * d;
      if constexpr (damped) {
        bend += weights[number] * d;
        rate += weights[number] * (at.v[j] - at.v[i]);
      }
    }
    for (int axis = 0; axis < 3; ++axis) forces(i, axis) += sum[axis];
    if constexpr (damped) {
      quads(scratch.bends)[i] = bend;
      quads(scratch.rates)[i] = rate;
    }
  }
}

CLOTHSIM_TARGET_CLONES
void sum_links(const TriangleFabric& fabric, const QuadMotion& at, bool damped, int begin, int end,
               Scratch& scratch, Points& forces) {
  if (damped) {
    sum_links_of<true>(fabric, at, begin, end, scratch, forces);
  } else {
    sum_links_of<false>(fabric, at, begin, end, scratch, forces);
  }
}

/// The angular velocity of each piece. Sums over pairs are sums over points: that of w d d^T is
/// that of -x_i sum_j w (x_j - x_i)^T; that of w d x d' alike.
std::vector<Vector3> rotations_of(const TriangleFabric& fabric, const Scratch& scratch) {
  std::vector<BendMotion> motions(fabric.pieces.size());
  add_curved_motions(fabric, QuadView(scratch.positions), QuadView(scratch.velocities), motions);
  for (std::size_t piece = 0; piece < motions.size(); ++piece) {
    const double tau = fabric.pieces[piece].internal_damping[1];  // as in the sums over points
    motions[piece].squares *= tau;
    motions[piece].moment *= tau;
    motions[piece].stiffness = tau * fabric.pieces[piece].weight;
  }
  for (std::size_t i = 0; i < fabric.piece_ids.size(); ++i) {
    const auto piece = static_cast<std::size_t>(fabric.piece_ids[i]);
    const auto centre = static_cast<std::size_t>(fabric.pieces[piece].first_point);
    const auto point = [](const std::vector<double>& quads, std::size_t k) {
      return Eigen::Map<const Vector3>(&quads[4 * k]);
    };
    const Vector3 arm = point(scratch.positions, i) - point(scratch.positions, centre);
    motions[piece].squares.noalias() -= arm * point(scratch.bends, i).transpose();
    motions[piece].moment -= arm.cross(point(scratch.rates, i));
  }
  std::vector<Vector3> rotations;
  for (const BendMotion& motion : motions) rotations.push_back(motion.rotation());
  return rotations;
}

/// Damping of bends, relative to the rotation of their piece: see remove_rotation().
void add_damping_of_bends(const TriangleFabric& fabric, const Scratch& scratch,
                          const Workers& workers, Points& forces) {
  const std::vector<Vector3> rotations = rotations_of(fabric, scratch);
  workers.parallel_for(static_cast<int>(fabric.piece_ids.size()), [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const Vector3& omega = rotations[static_cast<std::size_t>(fabric.piece_of(i))];
      const double* const b = &scratch.bends[4 * static_cast<std::size_t>(i)];
      const double* const rate = &scratch.rates[4 * static_cast<std::size_t>(i)];
      forces(i, 0) += rate[0] - (omega[1] * b[2] - omega[2] * b[1]);
      forces(i, 1) += rate[1] - (omega[2] * b[0] - omega[0] * b[2]);
      forces(i, 2) += rate[2] - (omega[0] * b[1] - omega[1] * b[0]);
    }
  });
  add_curved_damping(fabric, 1, QuadView(scratch.positions), QuadView(scratch.velocities),
                     rotations, workers, forces);
}

/// The factors of links [begin, end): pulls of both triangles of an edge, and bends.
void add_factors(const TriangleFabric& fabric, bool damped, int begin, int end, Scratch& scratch) {
  for (int l = begin; l < end; ++l) {
    const auto number = static_cast<std::size_t>(l);
    const double weight = fabric.pairs.empty() ? 0 : fabric.pairs[number].weight;
    scratch.factors[number] = weight;
    if (damped) {
      const double tau = fabric.internal_damping_at(fabric.pairs[number].i)[1];
      scratch.weights[number] = tau * weight;
    }
    if (number >= fabric.edges.size()) continue;
    const auto& [one, other] = fabric.pulls_of[number];
    scratch.factors[number] += 2 * (scratch.pulls[static_cast<std::size_t>(one)] +
                                    scratch.pulls[static_cast<std::size_t>(other)]);
  }
}

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

void compute_triangle_forces(const Cloth& cloth, const Loads& loads, const Points& positions,
                             Points& forces, const Workers& workers, const Points* velocities) {
  const TriangleFabric& fabric = *cloth.triangle_fabric;
  Scratch& scratch = scratch_of(fabric);
  const bool damped = velocities != nullptr && is_damped(cloth);
  const bool has_rates = damped && has_damped_bends(cloth);
  const QuadMotion at{quads(scratch.positions), damped ? quads(scratch.velocities) : nullptr};
  const auto num_triangles = static_cast<int>(fabric.triangles.size());

  workers.parallel_for(cloth.num_points(), [&](int begin, int end) {
    interleave(positions, begin, end, scratch.positions.data());
    if (damped) interleave(*velocities, begin, end, scratch.velocities.data());
  });
  workers.parallel_for(static_cast<int>(fabric.edges.size()), [&](int begin, int end) {
    square_edges(fabric, at, begin, end, scratch.squares.data());
  });
  workers.parallel_for(num_triangles, [&](int begin, int end) {
    pull_triangles(fabric, scratch.squares.data(), begin, end, scratch.pulls.data());
  });
  scratch.pulls.back() = 0;
  workers.parallel_for(static_cast<int>(scratch.factors.size()), [&](int begin, int end) {
    add_factors(fabric, has_rates, begin, end, scratch);
  });
  workers.parallel_for(cloth.num_points(), [&](int begin, int end) {
    for (int axis = 0; axis < 3; ++axis) {
      forces.col(axis).segment(begin, end - begin) =
          loads.gravity[axis] * cloth.mass.segment(begin, end - begin);
    }
    sum_links(fabric, at, has_rates, begin, end, scratch, forces);
  });
  add_curved_forces(fabric, QuadView(scratch.positions), workers, forces);
  if (has_rates) add_damping_of_bends(fabric, scratch, workers, forces);
}

Vector3 squared_edges(const std::array<int, 3>& corners, const Points& positions) {
  Vector3 squares;
  for (std::size_t k = 0; k < 3; ++k) {
    squares[static_cast<Eigen::Index>(k)] =
        (positions.row(corners[(k + 1) % 3]) - positions.row(corners[k])).squaredNorm();
  }
  return squares;
}

double membrane_energy(const Cloth& cloth, const Points& positions) {
  double energy = 0;
  for (std::size_t t = 0; t < cloth.triangles.size(); ++t) {
    const TriangleFabric::Triangle& triangle = cloth.triangle_fabric->triangles[t];
    const Vector3 change = squared_edges(cloth.triangles[t], positions) - triangle.rest2;
    energy += change.dot(triangle.stretch * change) / 2;
  }
  return energy;
}

Vector3 triangle_pulls(const Cloth& cloth, std::size_t triangle, const Points& positions,
                       const Points* velocities) {
  const std::array<int, 3>& corners = cloth.triangles[triangle];
  const TriangleFabric::Triangle& of = cloth.triangle_fabric->triangles[triangle];
  Vector3 change = squared_edges(corners, positions) - of.rest2;
  if (velocities == nullptr) return of.stretch * change;
  for (std::size_t k = 0; k < 3; ++k) {
    const int a = corners[k], b = corners[(k + 1) % 3];
    change[static_cast<Eigen::Index>(k)] +=
        2 * cloth.internal_damping_at(a)[0] *
        (positions.row(b) - positions.row(a)).dot(velocities->row(b) - velocities->row(a));
  }
  return of.stretch * change;
}

std::vector<double> edge_tensions(const Cloth& cloth, const Points& positions,
                                  const Points* velocities) {
  const TriangleFabric& fabric = *cloth.triangle_fabric;
  std::vector<double> tensions(fabric.edges.size(), 0.0);
  for (std::size_t t = 0; t < fabric.triangles.size(); ++t) {
    const Vector3 pulls = triangle_pulls(cloth, t, positions, velocities);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto e = static_cast<std::size_t>(fabric.triangles[t].edges[k]);
      const auto& [a, b] = fabric.edges[e];
      tensions[e] +=
          2 * pulls[static_cast<Eigen::Index>(k)] * (positions.row(b) - positions.row(a)).norm();
    }
  }
  return tensions;
}

Eigen::Matrix3d squared_derivatives(const Vector3& q, const Vector3& w) {
  Eigen::Matrix3d product;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Eigen::Index j = (i + 1) % 3;
    product(i, i) = q[i] * (w[i] + w[j]);
    product(i, j) = product(j, i) = -(q[3 - i - j] - q[i] - q[j]) / 2 * w[j];
  }
  return product;
}

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
