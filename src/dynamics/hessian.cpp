#include "clothsim/dynamics/hessian.h"

#include <algorithm>

namespace clothsim {

Eigen::Matrix3d spring_hessian(double stiffness, double rest_length, const Vector3& d,
                               double min_across) {
  const double length = d.norm();
  if (length == 0) return Eigen::Matrix3d::Zero();

  const double across = std::max(1 - rest_length / length, min_across);
  const Vector3 u = d / length;
  Eigen::Matrix3d hessian = (stiffness * (1 - across)) * u * u.transpose();
  hessian.diagonal().array() += stiffness * across;
  return hessian;
}

}  // namespace clothsim
