#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <array>
#include <cstddef>
#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// A symmetric positive definite system over the points of a cloth, with a 3 x 3 block for each
/// point and each pair that a spring, a bend or a cell joins. Pins have the unit block, without
/// springs.
///
/// Solved by conjugate gradients, or by Eigen's L D L^T with approximate minimum degree ordering
/// where they take longer: at 50 x 50 points 10 to 1000 steps of 0.05 ms, and 67 ms.
class SpringSystem {
 public:
  /// Sets all to zero, and lays out the matrix again where the joined points have changed.
  void begin(const Cloth& cloth);

  void add_to_point(int i, const Matrix3& block);

  /// Adds pair `id`, in the order of for_each_spring, for_each_bent_pair and for_each_cell (there
  /// of corners 0 1, 0 2, 1 2, 0 3, 1 3, 2 3), of free points a < b: `block` to both points,
  /// -`block` between them.
  void add_pair(int id, int a, int b, const Matrix3& block);

  /// Adds `block` in the rows of the pair's point b and the columns of its point a, and its
  /// transpose in the upper half.
  void add_between(int id, int a, const Matrix3& block);

  /// Rows [begin, end), which nothing joins to others. Row r is that of point points()[r].
  struct Piece {
    int begin;
    int end;
  };
  const std::vector<Piece>& pieces() const { return pieces_; }
  const std::vector<int>& points() const { return points_; }

  /// Solves for `rhs`, N x 3: by conjugate gradients for as long as a factorisation takes, then by
  /// that. False where neither succeeds, as for most matrices that are not positive definite.
  /// `negligible`: a square of the energy norm below which errors do not count, also in the next
  /// function.
  bool solve(const Points& rhs, double negligible, Points& solution);

  /// By conjugate gradients, preconditioned by the inverse blocks of the points (Saad 2003,
  /// "Iterative Methods for Sparse Linear Systems", 9.2), piece by piece, until the error's energy
  /// norm is estimated at a thousandth of the solution's. False where a piece takes more than
  /// `max_steps`, or a direction shows that the matrix is not positive definite.
  bool solve_by_gradients(const Points& rhs, double negligible, int max_steps, Points& solution);

  /// By factorisation. False where the matrix is not positive definite in floating point.
  bool solve_by_factors(const Points& rhs, Points& solution);

 private:
  using Joints = std::vector<std::array<int, 3>>;

  struct Factors : Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> {
    /// Sum of squares of the numbers of entries in each column of L.
    double work() const { return m_nonZerosPerCol.cast<double>().squaredNorm(); }
  };

  double* block(int number);
  const double* block(int number) const;
  std::size_t row_of(int point) const {
    return static_cast<std::size_t>(rows_[static_cast<std::size_t>(point)]);
  }
  void lay_out(const Cloth& cloth);
  void lay_out_rows(const Cloth& cloth);
  void lay_out_matrix();
  template <typename Visitor>
  void for_each_entry(Visitor&& visit) const;
  bool invert_points();
  bool solve_piece(const Piece& piece, double negligible, int max_steps, const Eigen::VectorXd& rhs,
                   Eigen::VectorXd& x) const;
  /// Four numbers a row, the last 0, and back to N x 3.
  Eigen::VectorXd in_rows(const Points&) const;
  Points by_points(const Eigen::VectorXd& rows) const;

  Joints joints_;  // of the layout
  std::vector<int> points_;
  std::vector<int> rows_;  // by point
  std::vector<Piece> pieces_;
  std::vector<int> ranks_;   // by pair: place of b among the ends of a
  std::vector<int> firsts_;  // by row: number of its own block, then those of its pairs with later
                             // rows, ascending; and the number of all
  std::vector<int> ends_;    // by block: its later row
  std::vector<double> blocks_;
  std::vector<double> inverses_;  // of the points' blocks

  // For factorisation.
  Eigen::SparseMatrix<double> matrix_;  // lower half
  Factors factors_;
  int max_steps_ = 0;  // of conjugate gradients in the same time
};

}  // namespace clothsim
