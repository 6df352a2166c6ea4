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

namespace clothsim {
namespace {

/// Coefficients of a symmetric 3 x 3 matrix, each in a column of its own: xx, yy, zz, xy, yz, xz.
enum { coefficients = 6 };

/// Bound on the error of single precision, of a frequency's square: some tens of roundings of the
/// sum of all springs at a point, which is less than three times that. Half of its digits are
/// enough.
const double single_margin = std::sqrt(std::numeric_limits<float>::epsilon());

/// Eigenvalues are compared, and returned, up to this share: otherwise each of several equal ones
/// would be computed.
constexpr double share = 512 * std::numeric_limits<double>::epsilon();

/// Points that are compared at once.
constexpr int batch = num_lanes;

/// Columns of matrices, `stride` numbers from one to the next.
template <typename Real>
struct Matrices {
  Real* first;
  int stride;
  Real* operator[](int coefficient) const { return first + coefficient * stride; }
};

/// A spring no longer than sqrt(min_direction2) [m] has no direction. It does not count, as it has
/// no force; in single precision, where that is uncertain, it counts in all directions.
template <typename Real>
constexpr Real min_direction2 = std::numeric_limits<Real>::min();
template <typename Real>
constexpr bool counts_without_length = false;
template <>
constexpr bool counts_without_length<float> = true;

/// Springs of one kind, between points and those `offset` further on in the columns x, y and z.
struct Springs {
  const double* x;
  const double* y;
  const double* z;
  int offset;
  double rest_length;
  double stiffness;
};

/// Stiffness k [u u^T + max(0, 1 - L0 / l) (I - u u^T)] of springs that begin at points [0, count).
template <typename Real>
[[gnu::always_inline]] inline void set_stiffness(const Springs& s, int count, Real* __restrict xx,
                                                 Real* __restrict yy, Real* __restrict zz,
                                                 Real* __restrict xy, Real* __restrict yz,
                                                 Real* __restrict xz) {
  const double* const x = s.x;
  const double* const y = s.y;
  const double* const z = s.z;
  const int offset = s.offset;
  const auto rest_length = static_cast<Real>(s.rest_length);
  const auto stiffness = static_cast<Real>(s.stiffness);
  const Real without_length = counts_without_length<Real> ? stiffness : Real{0};
  for (int i = 0; i < count; ++i) {
    const auto dx = static_cast<Real>(x[i + offset] - x[i]);
    const auto dy = static_cast<Real>(y[i + offset] - y[i]);
    const auto dz = static_cast<Real>(z[i + offset] - z[i]);
    const Real length2 = dx * dx + dy * dy + dz * dz;
    const bool has_length = length2 > min_direction2<Real>;
    const Real inverse = has_length ? 1 / std::sqrt(length2) : Real{0};
    const Real slack = 1 - rest_length * inverse;
    const Real across = slack > 0 ? slack : Real{0};
    const Real along = stiffness * (1 - across) * inverse * inverse;
    const Real all = has_length ? stiffness * across : without_length;
    xx[i] = along * dx * dx + all;
    yy[i] = along * dy * dy + all;
    zz[i] = along * dz * dz + all;
    xy[i] = along * dx * dy;
    yz[i] = along * dy * dz;
    xz[i] = along * dx * dz;
  }
}

CLOTHSIM_TARGET_CLONES
void stiffness_of(const Springs& s, int count, const Matrices<double>& to) {
  set_stiffness(s, count, to[0], to[1], to[2], to[3], to[4], to[5]);
}
CLOTHSIM_TARGET_CLONES
void stiffness_of(const Springs& s, int count, const Matrices<float>& to) {
  set_stiffness(s, count, to[0], to[1], to[2], to[3], to[4], to[5]);
}

/// Cells from one on, whose first corners are in the columns x, y and z: see CellBand.
struct CellColumns {
  const double* x;
  const double* y;
  const double* z;
  const CellBand& band;
  const double* stiffness;
};

/// What a cell adds to S_i at both ends of its first diagonal, and of its second one: see the
/// header. Each in six columns, those of the second after those of the first.
template <typename Real>
[[gnu::always_inline]] inline void set_cell_stiffness(const CellColumns& cells, int count,
                                                      const Matrices<Real>& to) {
  const int a = cells.band.a, b = cells.band.b;
  const auto p = static_cast<Real>(cells.band.strain.p), q = static_cast<Real>(cells.band.strain.q);
  const auto r = static_cast<Real>(cells.band.strain.r);
  const auto rest = static_cast<Real>(cells.band.strain.rest);
  const double* const columns[3] = {cells.x, cells.y, cells.z};
  const double* const stiffness = cells.stiffness;
  Real* const sums = to.first;
  const int stride = to.stride;
#pragma GCC ivdep
  for (int i = 0; i < count; ++i) {
    Real one[3], two[3], by[2][3];
    Real one2 = 0, two2 = 0, across = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double* const x = columns[axis] + i;
      one[axis] = static_cast<Real>(x[a + b] - x[0]);
      two[axis] = static_cast<Real>(x[b] - x[a]);
      one2 += one[axis] * one[axis];
      two2 += two[axis] * two[axis];
      across += one[axis] * two[axis];
    }
    const auto k = static_cast<Real>(stiffness[i]);
    const Real stress = k * (p * one2 + q * two2 + r * across - rest);
    for (int axis = 0; axis < 3; ++axis) {
      by[0][axis] = 2 * p * one[axis] + r * two[axis];
      by[1][axis] = 2 * q * two[axis] + r * one[axis];
    }
    const Real mixed = stress * r < 0 ? -stress * r : stress * r;
    const Real signs[2] = {p * stress, q * stress};
    for (int d = 0; d < 2; ++d) {
      const Real across_it = (signs[d] > 0 ? 2 * signs[d] : Real{0}) + mixed;
      Real* const s = sums + d * coefficients * stride + i;
      const Real twice = 2 * k;
      s[0] = twice * by[d][0] * by[d][0] + across_it;
      s[stride] = twice * by[d][1] * by[d][1] + across_it;
      s[2 * stride] = twice * by[d][2] * by[d][2] + across_it;
      s[3 * stride] = twice * by[d][0] * by[d][1];
      s[4 * stride] = twice * by[d][1] * by[d][2];
      s[5 * stride] = twice * by[d][0] * by[d][2];
    }
  }
}

CLOTHSIM_TARGET_CLONES
void stiffness_of(const CellColumns& cells, int count, const Matrices<double>& to) {
  set_cell_stiffness(cells, count, to);
}
CLOTHSIM_TARGET_CLONES
void stiffness_of(const CellColumns& cells, int count, const Matrices<float>& to) {
  set_cell_stiffness(cells, count, to);
}

CLOTHSIM_TARGET_CLONES
void add(const double* __restrict what, int count, double* __restrict sum) {
  for (int i = 0; i < count; ++i) sum[i] += what[i];
}
CLOTHSIM_TARGET_CLONES
void add(const float* __restrict what, int count, float* __restrict sum) {
  for (int i = 0; i < count; ++i) sum[i] += what[i];
}

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

/// S_i of a block of points, see the header: over springs that begin and springs that end at them.
template <typename Real>
class StiffnessBlock {
 public:
  /// For points [first, first + count), `count` at most `points_at_once`.
  void sum(const Cloth& cloth, const Points& positions, int first, int count) {
    sums_.assign(coefficients * points_at_once, 0);
    for (const CellBand& band : cloth.cell_bands) add_cells(band, positions, first, count);
    for_each_band(cloth, [&](const SpringBand& band) {
      const SpringRun& run = *band.begin;
      if (run.stiffness == 0) return;
      const int from = std::max(band.first(), first - run.offset);
      const int to = std::min(band.first() + band.count(), first + count);
      if (from >= to) return;

      const int stride = to - from;
      springs_.resize(static_cast<std::size_t>(coefficients * stride));
      const Matrices<Real> springs{springs_.data(), stride};
      stiffness_of({&positions(from, 0), &positions(from, 1), &positions(from, 2), run.offset,
                    run.rest_length, run.stiffness},
                   stride, springs);
      band.for_each_gap([&](int gap, int gap_end) {
        gap = std::max(gap + band.first(), from);
        gap_end = std::min(gap_end + band.first(), to);
        for (int c = 0; c < coefficients; ++c) {
          for (int i = gap; i < gap_end; ++i) springs[c][i - from] = 0;
        }
      });

      const int begins = std::max(from, first);
      const int ends = std::min(to, first + count - run.offset);
      for (int c = 0; c < coefficients; ++c) {
        add(springs[c] + (begins - from), to - begins, matrices()[c] + (begins - first));
        add(springs[c], ends - from, matrices()[c] + (from + run.offset - first));
      }
    });
  }

  Matrices<Real> matrices() { return {sums_.data(), points_at_once}; }

 private:
  void add_cells(const CellBand& band, const Points& positions, int first, int count) {
    const int last = band.a + band.b;
    const int from = std::max(0, first - last);
    const int to = std::min(static_cast<int>(band.stiffness.size()), first + count);
    if (from >= to) return;
    const int stride = to - from;
    springs_.resize(static_cast<std::size_t>(2 * coefficients * stride));
    const Matrices<Real> cells{springs_.data(), stride};
    stiffness_of({&positions(from, 0), &positions(from, 1), &positions(from, 2), band,
                  &band.stiffness[from]},
                 stride, cells);
    for (const auto& [corner, diagonal] : {std::pair(0, 0), {last, 0}, {band.a, 1}, {band.b, 1}}) {
      const int begin = std::max(from, first - corner);
      const int end = std::min(to, first + count - corner);
      for (int c = 0; c < coefficients && begin < end; ++c) {
        add(cells[coefficients * diagonal + c] + (begin - from), end - begin,
            matrices()[c] + (begin + corner - first));
      }
    }
  }

  std::vector<Real> sums_;
  std::vector<Real> springs_;  // of one band, or its cells
};

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
    omega = std::max(omega, added[p].with(membranes[p]));
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
  const double springs = springs_bound(cloth, positions, added.without(min_omega), workers);
  return std::max(added.with(springs), min_omega);
}

double omega_max_bound(const Cloth& cloth) {
  if (cloth.is_mesh() || !cloth.cells.empty()) return infinity;
  const BendsAndDamping added{bends_omega2(cloth), cloth.internal_damping};
  return added.with(springs_bound(cloth));
}

}  // namespace clothsim
