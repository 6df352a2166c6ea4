#include "algebra.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>

namespace clothsim::test {

Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& matrix) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly)
      .eigenvalues();
}

Eigen::MatrixXd solve(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.colPivHouseholderQr().solve(b);
}

Eigen::Quaterniond turn_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d a = from.normalized(), b = to.normalized();
  const double cosine = b.dot(a);
  Eigen::Quaterniond turn;
  if (cosine < -1 + 1e-12) {
    turn.w() = 0;
    turn.vec() = a.unitOrthogonal();
  } else {
    const double twice_w = std::sqrt((1 + cosine) * 2);
    turn.w() = twice_w / 2;
    turn.vec() = a.cross(b) * (1 / twice_w);
  }
  return turn;
}

}  // namespace clothsim::test
