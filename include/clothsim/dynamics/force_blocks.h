#pragma once

#include <array>
#include <vector>

#include "clothsim/dynamics/forces.h"

namespace clothsim {

/// Points that are summed at once: the forces of their springs fit the second-level cache.
/// Measured; shorter loops lose more than the first level wins.
inline constexpr int points_at_once = 2560;

/// Gravity and the forces of springs and bends on points [begin, end) of a cloth, a block of points
/// at a time:
///
///   for (ForceBlocks<double> blocks(cloth, loads, positions, begin, end); blocks.next();) {
///     blocks.sum(axis, f);  // f[i] acts on point blocks.first() + i, i < blocks.count()
///   }
///
/// Springs of one offset are computed for a whole block as if every point had one, the few that do
/// not exist are cleared, and each point sums the forces from both sides: no force is added to
/// memory twice, and data of earlier blocks stays in the nearest caches. A point's force is the
/// same to the last bit wherever blocks begin and end.
///
/// `Real`: double, or float. With float, springs are computed and summed in single precision, twice
/// as many at once.
template <typename Real>
class ForceBlocks {
 public:
  /// All must outlive this. `positions`: N x 3 [m]. `velocities`: N x 3 [m/s], for internal
  /// damping, of bends by remove_rotation(); null: no damping.
  ForceBlocks(const Cloth&, const Loads&, const Points& positions, int begin, int end,
              const Points* velocities = nullptr);

  /// Moves to the next block; false where none is left.
  bool next();

  int first() const { return first_; }
  int count() const { return count_; }

  /// Writes the forces [N] on the block's points along `axis`.
  void sum(int axis, Real* forces) const;

 private:
  /// Springs of one offset, length and stiffness, neighbours in cloth.springs, ascending; or all of
  /// a fabric's `pairs`.
  struct Direction {
    int offset;
    const PairBand* pairs;
    const SpringRun* run;  // the first that may reach into the block
    const SpringRun* end;
    Real* force[3];  // on the first points of its springs, after those of earlier points
  };
  /// Cells, with the bends along both diagonals, if any.
  struct Cells {
    const CellBand* band;
    std::array<const PairBand*, 2> bends;
    Real* force[6];  // on the first ends of each diagonal, by first corner, as above

    int reach() const { return band->a + band->b; }
  };

  void group();
  void group_bands();
  const PairBand* bends_of_cells(const CellBand&, int offset, int lead) const;
  void take_points();
  template <typename Item>
  Real* place(int reach, int kept, Real* free, Item& item);
  void fill(Direction&, int first, int count, Real* const force[3]) const;
  void fill(const Cells&, int first, int count, Real* const force[6]) const;
  /// Computes the forces of springs or pairs with the first points [from, from + count).
  void pull_between(const Direction&, int from, int count, Real* const force[3]) const;
  void keep_history();

  const Cloth& cloth_;
  const Loads& loads_;
  const Points& positions_;
  int first_;
  int count_ = 0;
  int end_;
  std::vector<Direction> directions_;
  std::vector<Cells> cells_;
  const Points* velocities_;                         // null: no damping
  const Real* points_[3];                            // columns of positions
  const Real* rates_[3];                             // of velocities, if any
  Eigen::Matrix<Real, Eigen::Dynamic, 1> narrowed_;  // both, where Real is not double
  Eigen::Matrix<Real, Eigen::Dynamic, 1> buffer_;    // of all directions
};

}  // namespace clothsim
