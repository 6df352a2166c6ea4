#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

// Compiled once: a file that names these solvers of Eigen itself takes seconds longer to compile.

namespace clothsim::test {

/// Eigenvalues of a symmetric matrix, the least first.
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& matrix);

/// The X that solves A X = B, with the least squares of A X - B where A has more rows than columns.
Eigen::MatrixXd solve(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// The least rotation that takes the direction `from` to the direction `to`. Eigen's own
/// function makes the compiler read a singular value decomposition.
Eigen::Quaterniond turn_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace clothsim::test
