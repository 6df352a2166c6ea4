#pragma once

#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// Coefficients of a symmetric 3 x 3 matrix, each in a column of its own: xx, yy, zz, xy, yz, xz.
enum { coefficients = 6 };

/// Columns of matrices, `stride` numbers from one to the next.
template <typename Real>
struct Matrices {
  Real* first;
  int stride;
  Real* operator[](int coefficient) const { return first + coefficient * stride; }
};

/// S_i of a block of points, see omega_max_bound(): over the springs and cells at them. `Real`:
/// double or float.
template <typename Real>
class StiffnessBlock {
 public:
  /// For points [first, first + count), `count` at most `points_at_once`.
  void sum(const Cloth&, const Points& positions, int first, int count);

  Matrices<Real> matrices();

 private:
  void add_cells(const CellBand&, const Points& positions, int first, int count);

  std::vector<Real> sums_;
  std::vector<Real> springs_;  // of one band, or its cells
};

}  // namespace clothsim
