#include "clothsim/dynamics/spectrum.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "clothsim/dynamics/springs.h"

namespace clothsim {

double omega_max_bound(const Cloth& cloth, const Points& positions) {
  // S_i by point: xx, yy, zz, xy, yz, xz.
  Eigen::Matrix<double, 6, Eigen::Dynamic> blocks;
  blocks.setZero(6, cloth.num_points());

  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const Vector3 d = positions.row(b) - positions.row(a);
    const double length2 = d.squaredNorm();
    if (length2 == 0) return;  // gives no force
    const double across = std::max(0.0, 1 - run.rest_length / std::sqrt(length2));
    const double along = run.stiffness * (1 - across) / length2;
    const double all = run.stiffness * across;
    Eigen::Matrix<double, 6, 1> s;
    s << along * d.x() * d.x() + all, along * d.y() * d.y() + all, along * d.z() * d.z() + all,
        along * d.x() * d.y(), along * d.y() * d.z(), along * d.x() * d.z();
    blocks.col(a) += s;
    blocks.col(b) += s;
  });

  double omega2 = 0;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (cloth.inv_mass[i] == 0) continue;
    const auto s = blocks.col(i);
    Eigen::Matrix3d block;
    block << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
    solver.computeDirect(block, Eigen::EigenvaluesOnly);
    omega2 = std::max(omega2, 2 * solver.eigenvalues()[2] * cloth.inv_mass[i]);
  }
  return std::sqrt(omega2);
}

}  // namespace clothsim
