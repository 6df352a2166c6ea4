#include "clothsim/dynamics/spectrum.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <vector>

#include "clothsim/dynamics/curved_bends.h"
#include "clothsim/dynamics/force_blocks.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/triangle_forces.h"
#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"
#include "stiffness_block.h"

namespace clothsim {
namespace {

/// Bound on the error of single precision, of a frequency's square: some tens of roundings of the
/// sum of all springs at a point, which is less than three times that. Half of its digits are
/// enough.
const double single_margin = std::sqrt(std::numeric_limits<float>::epsilon());

/// Eigenvalues are compared, and returned, up to this share: otherwise each of several equal ones
/// would be computed.
constexpr double share = 512 * std::numeric_limits<double>::epsilon();

/// Points that are compared at once.
constexpr int batch = num_lanes;

/// Number of points i in [0, count) with an eigenvalue of 2 s / m above `omega2`, by the pivots of
/// omega2 m / 2 - s: far cheaper than the values. Pins (no inverse mass) have none.
template <typename Real>
[[gnu::always_inline]] inline int counted_above(const Matrices<Real>& s, const double* inv_mass,
                                                int count, double omega2) {
  int above = 0;
  for (int i = 0; i < count; ++i) {
    const auto bound = static_cast<Real>(omega2 / (2 * inv_mass[i]));
    const Real first = bound - s[0][i];
    const Real second = bound - s[1][i] - s[3][i] * s[3][i] / first;
    const Real yz = -s[4][i] - s[3][i] * s[5][i] / first;
    const Real third = bound - s[2][i] - s[5][i] * s[5][i] / first - yz * yz / second;
    const bool below = first > 0 && second > 0 && third > 0;
    above += inv_mass[i] > 0 && !below;
  }
  return above;
}

CLOTHSIM_TARGET_CLONES
bool are_below(const Matrices<double>& s, const double* inv_mass, int count, double omega2) {
  return counted_above(s, inv_mass, count, omega2) == 0;
}
CLOTHSIM_TARGET_CLONES
bool are_below(const Matrices<float>& s, const double* inv_mass, int count, double omega2) {
  return counted_above(s, inv_mass, count, omega2) == 0;
}

/// Does single precision prove that all frequencies are below `omega`?
bool are_surely_below(const Cloth& cloth, const Points& positions, double omega,
                      const Workers& workers) {
  const double omega2 = omega * omega * (1 - single_margin);
  std::atomic<bool> below{true};
  workers.parallel_for(cloth.num_points(), [&](int begin, int end) {
    StiffnessBlock<float> points;
    for (int first = begin; first < end; first += points_at_once) {
      const int count = std::min(points_at_once, end - first);
      points.sum(cloth, positions, first, count);
      if (!are_below(points.matrices(), &cloth.inv_mass[first], count, omega2)) below = false;
    }
  });
  return below;
}

double largest_eigenvalue(const Matrices<double>& s, int i) {
  Eigen::Matrix3d matrix;
  matrix << s[0][i], s[3][i], s[5][i], s[3][i], s[1][i], s[4][i], s[5][i], s[4][i], s[2][i];
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(matrix, Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[2];
}

/// omega_b^2 of a grid's bends.
double bends_omega2(const Cloth& cloth) {
  if (cloth.pairs.empty()) return 0;
  Scalars sums = Scalars::Zero(cloth.num_points());
  for (const PairBand& band : cloth.pairs) {  // entries off the diagonal, and their part of it
    const auto count = band.bend.size();
    sums.head(count) += band.bend.cwiseAbs() + band.bend;
    sums.tail(count) += band.bend.cwiseAbs() + band.bend;
  }
  return sums.cwiseProduct(cloth.inv_mass).maxCoeff();
}

/// The same for each piece of a mesh. Where triangles are curved at rest, |b - B n|^2 changes by at
/// most the square of the sum of both changes.
std::vector<double> bends_omega2_by_piece(const Cloth& cloth, const Points& positions) {
  const TriangleFabric& fabric = *cloth.triangle_fabric;
  Scalars sums = Scalars::Zero(cloth.num_points());
  for (const auto& [i, j, weight] : fabric.pairs) {
    sums[i] += std::abs(weight) + weight;
    sums[j] += std::abs(weight) + weight;
  }
  const auto largest = [&] {
    std::vector<double> of_pieces(fabric.pieces.size(), 0.0);
    for (int i = 0; i < cloth.num_points(); ++i) {
      double& omega2 = of_pieces[static_cast<std::size_t>(fabric.piece_of(i))];
      omega2 = std::max(omega2, sums[i] * cloth.inv_mass[i]);
    }
    return of_pieces;
  };
  std::vector<double> all = largest();
  if (fabric.curved.empty()) return all;
  sums.setZero();
  add_curved_sums(cloth, positions, sums);
  const std::vector<double> of_curved = largest();
  for (std::size_t p = 0; p < all.size(); ++p) {
    all[p] += of_curved[p] + 2 * std::sqrt(all[p] * of_curved[p]);
  }
  return all;
}

/// The effect of bends and internal damping on the springs' frequencies.
struct BendsAndDamping {
  double bends;  // omega_b^2
  std::array<double, 2> damping;

  /// Is there any effect?
  bool any() const { return bends > 0 || damping != std::array<double, 2>{}; }

  /// The frequency for springs of omega_s.
  double with(double springs) const {
    if (!any()) return springs;
    const double rate = damping[0] * springs * springs + damping[1] * bends;
    return (rate + std::sqrt(rate * rate + 4 * (springs * springs + bends))) / 2;
  }

  /// Frequency of the springs for which `with` gives `omega`; zero where that of bends alone is
  /// higher.
  double without(double omega) const {
    if (!any()) return omega;
    const double left = omega * omega - bends * (1 + damping[1] * omega);
    return std::sqrt(std::max(left, 0.0) / (1 + damping[0] * omega));
  }
};

/// omega_max_bound() of a mesh: the largest of its pieces, each with its own damping.
double mesh_bound(const Cloth& cloth, const Points& positions, double min_omega) {
  const std::vector<double> bends = bends_omega2_by_piece(cloth, positions);
  std::vector<BendsAndDamping> added;
  std::vector<double> least;
  for (std::size_t p = 0; p < bends.size(); ++p) {
    added.push_back({bends[p], cloth.triangle_fabric->pieces[p].internal_damping});
    least.push_back(added[p].without(min_omega));
  }
  const std::vector<double> membranes = membrane_bounds(cloth, positions, least);
  double omega = min_omega;
  for (std::size_t p = 0; p < bends.size(); ++p) {
    if (membranes[p] > least[p] || least[p] == 0) {
      omega = std::max(omega, added[p].with(membranes[p]));
    }
  }
  return omega;
}

double springs_bound(const Cloth& cloth, const Points& positions, double min_omega,
                     const Workers& workers) {
  if (min_omega > 0 && are_surely_below(cloth, positions, min_omega, workers)) return min_omega;

  const int n = cloth.num_points();
  StiffnessBlock<double> points;
  double omega2 = min_omega * min_omega;
  for (int first = 0; first < n; first += batch) {
    if (first % points_at_once == 0)
      points.sum(cloth, positions, first, std::min(points_at_once, n - first));
    const Matrices<double> s{points.matrices()[0] + first % points_at_once, points_at_once};
    const int count = std::min(batch, n - first);
    const double bound = omega2 * (1 + share);
    if (are_below(s, &cloth.inv_mass[first], count, bound)) continue;
    for (int i = 0; i < count; ++i) {
      const double inv_mass = cloth.inv_mass[first + i];
      const Matrices<double> of_point{s[0] + i, points_at_once};
      if (are_below(of_point, &inv_mass, 1, omega2 * (1 + share))) continue;
      omega2 = std::max(omega2, 2 * largest_eigenvalue(s, i) * inv_mass);
    }
  }
  return omega2 > min_omega * min_omega ? std::sqrt(omega2 * (1 + share)) : min_omega;
}

double springs_bound(const Cloth& cloth) {
  Scalars stiffness = Scalars::Zero(cloth.num_points());
  for_each_band(cloth, [&](const SpringBand& band) {  // gaps between runs included
    stiffness.segment(band.first(), band.count()).array() += band.begin->stiffness;
    stiffness.segment(band.first() + band.begin->offset, band.count()).array() +=
        band.begin->stiffness;
  });
  return std::sqrt(2 * stiffness.cwiseProduct(cloth.inv_mass).maxCoeff());
}

}  // namespace

double omega_max_bound(const Cloth& cloth, const Points& positions, double min_omega,
                       const Workers& workers) {
  if (cloth.is_mesh()) return mesh_bound(cloth, positions, min_omega);
  const BendsAndDamping added{bends_omega2(cloth), cloth.internal_damping};
  const double least = added.without(min_omega);
  const double springs = springs_bound(cloth, positions, least, workers);
  return springs > least || least == 0 ? std::max(added.with(springs), min_omega) : min_omega;
}

double omega_max_bound(const Cloth& cloth) {
  if (cloth.is_mesh() || !cloth.cells.empty()) return infinity;
  const BendsAndDamping added{bends_omega2(cloth), cloth.internal_damping};
  return added.with(springs_bound(cloth));
}

}  // namespace clothsim
