#pragma once

#include <vector>

#include "clothsim/dynamics/forces.h"

namespace clothsim {

/// Gravity and spring forces on points [begin, end) of a cloth, a block of points at a time:
///
///   for (ForceBlocks<double> blocks(cloth, loads, positions, begin, end); blocks.next();) {
///     blocks.sum(axis, f);  // f[i] acts on point blocks.first() + i, i < blocks.count()
///   }
///
/// Springs of one offset are computed for a whole block as if every point had one, the few that are
/// none are cleared, and each point sums what pulls it from both sides: no force is added to memory
/// twice, and what a block needs of earlier ones stays in the nearest caches. A point's force is
/// the same to the last bit wherever blocks begin and end.
///
/// `Real`: double, or float. Then springs are computed and summed in single precision, twice as
/// many at once.
template <typename Real>
class ForceBlocks {
 public:
  /// All three must outlive this. `positions`: N x 3 [m].
  ForceBlocks(const Cloth&, const Loads&, const Points& positions, int begin, int end);

  /// Goes to the next block; false where none is left.
  bool next();

  int first() const { return first_; }
  int count() const { return count_; }

  /// Writes the forces [N] on the block's points along `axis`.
  void sum(int axis, Real* forces) const;

 private:
  /// Springs of one offset, length and stiffness: neighbours in cloth.springs, ascending.
  struct Direction {
    const SpringRun* run;  // the first that may reach into the block
    const SpringRun* end;
    Real* force[3];  // on the first points of the block's springs, after those of points before
  };

  void group();
  void take_points();
  void fill(Direction&, int first, int count, Real* const force[3]) const;
  void keep_history();

  const Cloth& cloth_;
  const Loads& loads_;
  const Points& positions_;
  int first_;
  int count_ = 0;
  int end_;
  std::vector<Direction> directions_;
  const Real* points_[3];                            // columns of positions
  Eigen::Matrix<Real, Eigen::Dynamic, 1> narrowed_;  // these, where Real is not double
  Eigen::Matrix<Real, Eigen::Dynamic, 1> buffer_;    // of all directions
};

}  // namespace clothsim
