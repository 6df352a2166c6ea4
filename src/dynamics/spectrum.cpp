#include "clothsim/dynamics/spectrum.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "clothsim/dynamics/springs.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// Symmetric 3 x 3 matrices, each coefficient in a column of its own: xx, yy, zz, xy, yz, xz.
using Blocks = Eigen::Matrix<double, Eigen::Dynamic, 6>;
using Columns = std::array<double*, 6>;

Columns columns_from(Blocks& blocks, Eigen::Index row) {
  return {&blocks(row, 0), &blocks(row, 1), &blocks(row, 2),
          &blocks(row, 3), &blocks(row, 4), &blocks(row, 5)};
}

/// Eigenvalues are compared, and returned, up to this share: among equal ones each would have to be
/// computed.
constexpr double share = 1e-13;

/// Points that are compared at once.
constexpr int batch = 64;

/// Stiffness k [u u^T + max(0, 1 - L0 / l) (I - u u^T)] of springs (i, i + offset), i in [0,
/// count).
CLOTHSIM_TARGET_CLONES
void stiffness_of(const double* x, const double* y, const double* z, int offset, int count,
                  double rest_length, double stiffness, double* __restrict xx,
                  double* __restrict yy, double* __restrict zz, double* __restrict xy,
                  double* __restrict yz, double* __restrict xz) {
  for (int i = 0; i < count; ++i) {
    const double dx = x[i + offset] - x[i];
    const double dy = y[i + offset] - y[i];
    const double dz = z[i + offset] - z[i];
    const double length2 = dx * dx + dy * dy + dz * dz;
    const double inverse = length2 > 0 ? 1 / std::sqrt(length2) : 0.0;
    const double slack = 1 - rest_length * inverse;
    const double across = slack > 0 ? slack : 0.0;
    const double along = stiffness * (1 - across) * inverse * inverse;
    const double all = length2 > 0 ? stiffness * across : 0.0;  // no length, no force
    xx[i] = along * dx * dx + all;
    yy[i] = along * dy * dy + all;
    zz[i] = along * dz * dz + all;
    xy[i] = along * dx * dy;
    yz[i] = along * dy * dz;
    xz[i] = along * dx * dz;
  }
}

CLOTHSIM_TARGET_CLONES
void add(const double* __restrict what, int count, double* __restrict sum) {
  for (int i = 0; i < count; ++i) sum[i] += what[i];
}

/// Have all points i in [0, count) only eigenvalues of 2 s / m below `omega2`? By the pivots of
/// omega2 m / 2 - s: far cheaper than the values. Pins (no inverse mass) have.
CLOTHSIM_TARGET_CLONES
bool are_below(Columns s, const double* inv_mass, int count, double omega2) {
  int above = 0;
  for (int i = 0; i < count; ++i) {
    const double bound = omega2 / (2 * inv_mass[i]);
    const double first = bound - s[0][i];
    const double second = bound - s[1][i] - s[3][i] * s[3][i] / first;
    const double yz = -s[4][i] - s[3][i] * s[5][i] / first;
    const double third = bound - s[2][i] - s[5][i] * s[5][i] / first - yz * yz / second;
    const bool below = first > 0 && second > 0 && third > 0;
    above += inv_mass[i] > 0 && !below;
  }
  return above == 0;
}

double largest_eigenvalue(const Blocks& s, int i) {
  Eigen::Matrix3d block;
  block << s(i, 0), s(i, 3), s(i, 5), s(i, 3), s(i, 1), s(i, 4), s(i, 5), s(i, 4), s(i, 2);
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(block, Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[2];
}

}  // namespace

double omega_max_bound(const Cloth& cloth, const Points& positions, double least) {
  // S_i by point.
  const int n = cloth.num_points();
  Blocks blocks = Blocks::Zero(n, 6);
  Blocks of_springs(n, 6);
  for_each_band(cloth, [&](const SpringBand& band) {
    const int a = band.first();
    const int count = band.count();
    stiffness_of(&positions(a, 0), &positions(a, 1), &positions(a, 2), band.begin->offset, count,
                 band.begin->rest_length, band.begin->stiffness, &of_springs(0, 0),
                 &of_springs(0, 1), &of_springs(0, 2), &of_springs(0, 3), &of_springs(0, 4),
                 &of_springs(0, 5));
    band.for_each_gap([&](int from, int to) { of_springs.middleRows(from, to - from).setZero(); });
    for (int c = 0; c < 6; ++c) {
      add(&of_springs(0, c), count, &blocks(a, c));
      add(&of_springs(0, c), count, &blocks(a + band.begin->offset, c));
    }
  });

  double omega2 = least * least;
  for (int first = 0; first < n; first += batch) {
    const int count = std::min(batch, n - first);
    const double bound = omega2 * (1 + share);
    if (are_below(columns_from(blocks, first), &cloth.inv_mass[first], count, bound)) continue;
    for (int i = first; i < first + count; ++i) {
      const double inv_mass = cloth.inv_mass[i];
      const Columns s = columns_from(blocks, i);
      if (are_below(s, &inv_mass, 1, omega2 * (1 + share))) continue;
      omega2 = std::max(omega2, 2 * largest_eigenvalue(blocks, i) * inv_mass);
    }
  }
  return omega2 > least * least ? std::sqrt(omega2 * (1 + share)) : least;
}

double omega_max_bound(const Cloth& cloth) {
  Scalars stiffness = Scalars::Zero(cloth.num_points());
  for (const SpringRun& run : cloth.springs) {
    stiffness.segment(run.first, run.count).array() += run.stiffness;
    stiffness.segment(run.first + run.offset, run.count).array() += run.stiffness;
  }
  return std::sqrt(2 * stiffness.cwiseProduct(cloth.inv_mass).maxCoeff());
}

}  // namespace clothsim
