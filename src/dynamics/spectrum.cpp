#include "clothsim/dynamics/spectrum.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "clothsim/dynamics/springs.h"

namespace clothsim {
namespace {

/// A symmetric 3 x 3 matrix: xx, yy, zz, xy, yz, xz.
using Block = Eigen::Matrix<double, 6, 1>;

/// Are all eigenvalues of s below `bound`? By the pivots of bound - s: far cheaper than the values.
bool is_below(const Block& s, double bound) {
  const double first = bound - s[0];
  if (!(first > 0)) return false;
  const double second = bound - s[1] - s[3] * s[3] / first;
  const double yz = -s[4] - s[3] * s[5] / first;
  return second > 0 && bound - s[2] - s[5] * s[5] / first - yz * yz / second > 0;
}

}  // namespace

double omega_max_bound(const Cloth& cloth, const Points& positions) {
  // S_i by point.
  Eigen::Matrix<double, 6, Eigen::Dynamic> blocks;
  blocks.setZero(6, cloth.num_points());

  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const double x = positions(b, 0) - positions(a, 0);
    const double y = positions(b, 1) - positions(a, 1);
    const double z = positions(b, 2) - positions(a, 2);
    const double length2 = x * x + y * y + z * z;
    if (length2 == 0) return;  // gives no force
    const double across = std::max(0.0, 1 - run.rest_length / std::sqrt(length2));
    const double along = run.stiffness * (1 - across) / length2;
    const double all = run.stiffness * across;
    Block s;
    s << along * x * x + all, along * y * y + all, along * z * z + all, along * x * y,
        along * y * z, along * x * z;
    blocks.col(a) += s;
    blocks.col(b) += s;
  });

  double omega2 = 0;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (cloth.inv_mass[i] == 0) continue;
    const auto s = blocks.col(i);
    if (is_below(s, omega2 / (2 * cloth.inv_mass[i]))) continue;
    Eigen::Matrix3d block;
    block << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
    solver.computeDirect(block, Eigen::EigenvaluesOnly);
    omega2 = std::max(omega2, 2 * solver.eigenvalues()[2] * cloth.inv_mass[i]);
  }
  return std::sqrt(omega2);
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
