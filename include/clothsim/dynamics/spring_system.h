#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <vector>

#include "clothsim/dynamics/bends.h"
#include "clothsim/dynamics/cells.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/model/cloth.h"

namespace clothsim {

/// A symmetric positive definite system over the points of a cloth, with a Size x Size block for
/// each point and each pair that a spring, a bend or a cell joins. Pins have the unit block,
/// without springs.
///
/// Solved by Eigen's L D L^T with approximate minimum degree ordering. At 50 x 50 points with
/// blocks of 3 it factorises in 46 ms; CHOLMOD of SuiteSparse takes 69 ms (supernodal) and 60 ms
/// (simplicial) with Debian's plain BLAS, and 38 ms with OpenBLAS, which would be one more
/// dependency.
template <int Size>
class SpringSystem {
 public:
  using Block = Eigen::Matrix<double, Size, Size>;

  /// Sets all to zero, and lays out the matrix again where the joined points have changed.
  void begin(const Cloth& cloth) {
    Joints joints{{cloth.num_points(), static_cast<int>(cloth.springs.size()),
                   static_cast<int>(cloth.bends.size())}};
    for (const SpringRun& run : cloth.springs) joints.push_back({run.first, run.offset, run.count});
    for (const BendRun& run : cloth.bends) {
      joints.push_back({run.first, run.a, run.count});
      joints.push_back({run.first, run.b, run.count});
    }
    for (const CellRun& run : cloth.cells) {
      joints.push_back({run.first, run.a, run.count});
      joints.push_back({run.first, run.b, run.count});
    }
    if (cloth.is_mesh()) {
      for (const auto& pair : cloth.triangle_fabric->pairs) joints.push_back({pair.i, pair.j, 1});
    }
    if (joints != joints_) {
      joints_ = std::move(joints);
      lay_out(cloth);
    }
    std::fill_n(matrix_.valuePtr(), matrix_.nonZeros(), 0.0);
  }

  void add_to_point(int i, const Block& block) {
    for (int c = 0; c < Size; ++c) {
      double* values = column(i, c);
      for (int r = c; r < Size; ++r) values[r - c] += block(r, c);
    }
  }

  /// Adds pair `id`, in the order of for_each_spring, for_each_bent_pair and for_each_cell (there
  /// of corners 0 1, 0 2, 1 2, 0 3, 1 3, 2 3), of free points a < b: `block` to both points,
  /// -`block` between them.
  void add_pair(int id, int a, int b, const Block& block) {
    add_to_point(a, block);
    add_to_point(b, block);
    add_between(id, a, -block);
  }

  /// Adds `block` in the rows of the pair's point b and the columns of its point a, and its
  /// transpose in the upper half.
  void add_between(int id, int a, const Block& block) {
    const int rank = ranks_[static_cast<std::size_t>(id)];
    for (int c = 0; c < Size; ++c) {
      double* values = column(a, c) + (Size - c) + Size * rank;
      for (int r = 0; r < Size; ++r) values[r] += block(r, c);
    }
  }

  /// False where the matrix is not positive definite in floating point.
  bool factorize() {
    solver_.factorize(matrix_);
    return solver_.info() == Eigen::Success && (solver_.vectorD().array() > 0).all();
  }

  template <typename Rhs>
  auto solve(const Rhs& rhs) const {
    return solver_.solve(rhs);
  }

 private:
  using Joints = std::vector<std::array<int, 3>>;

  double* column(int point, int c) {
    return matrix_.valuePtr() + matrix_.outerIndexPtr()[Size * point + c];
  }

  template <typename Visitor>
  static void for_each_joint(const Cloth& cloth, Visitor&& visit) {
    for_each_spring(cloth, [&](const SpringRun&, int a, int b) { visit(a, b); });
    for_each_bent_pair(cloth, [&](double, int a, int b) { visit(a, b); });
    for_each_cell(cloth, [&](const Cell& cell) {
      for (std::size_t l = 0; l < cell.corners.size(); ++l) {
        for (std::size_t k = 0; k < l; ++k) visit(cell.corners[k], cell.corners[l]);
      }
    });
  }

  void lay_out(const Cloth& cloth) {
    // Entries below the diagonal: for each point the other ends, ascending.
    const int n = cloth.num_points();
    std::vector<std::vector<int>> ends(static_cast<std::size_t>(n));
    for_each_joint(cloth, [&](int a, int b) { ends[static_cast<std::size_t>(a)].push_back(b); });
    for (std::vector<int>& list : ends) {
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
    }

    ranks_.clear();
    for_each_joint(cloth, [&](int a, int b) {
      const std::vector<int>& list = ends[static_cast<std::size_t>(a)];
      const auto place = std::lower_bound(list.begin(), list.end(), b);
      ranks_.push_back(static_cast<int>(place - list.begin()));
    });

    std::vector<Eigen::Triplet<double>> entries;
    for (int a = 0; a < n; ++a) {
      for (int c = 0; c < Size; ++c) {
        for (int r = c; r < Size; ++r) entries.emplace_back(Size * a + r, Size * a + c, 1.0);
        for (const int b : ends[static_cast<std::size_t>(a)]) {
          for (int r = 0; r < Size; ++r) entries.emplace_back(Size * b + r, Size * a + c, 1.0);
        }
      }
    }
    matrix_.resize(Size * n, Size * n);
    matrix_.setFromTriplets(entries.begin(), entries.end());
    solver_.analyzePattern(matrix_);
  }

  Joints joints_;                       // of the layout
  std::vector<int> ranks_;              // by pair: place of b among the ends of a
  Eigen::SparseMatrix<double> matrix_;  // lower half
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> solver_;
};

}  // namespace clothsim
