#pragma once

#include <array>
#include <vector>

#include "clothsim/geometry/box_tree.h"
#include "clothsim/geometry/tiling.h"
#include "clothsim/model/types.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// Neighbouring tiles of a surface, on a grid in a square, row by row.
struct Patch {
  static constexpr int side = 4;  // tiles along it, on a grid
  static constexpr int none = -1;

  std::array<int, side * side> tiles;  // `none` where there are fewer
  std::vector<int> points;             // all corners of the tiles, each once
};

/// For a grid: its rectangles along rows, smaller ones at the last row and column.
std::vector<Patch> cut_into_patches(const Tiling&, int columns, int rows);

/// For any surface at `rest` [m, N x 3]: repeated halves, cut across the longest extent.
std::vector<Patch> cut_into_patches(const Tiling&, const Points& rest);

/// Relative motion of patches while points move on straight paths.
class PatchMotions {
 public:
  /// Sets the displacements of the points of `patches` from one set of positions to another [m, N x
  /// 3, finite].
  void follow(const std::vector<Patch>& patches, const Points& from, const Points& to,
              const Workers& = {});

  /// Largest approach of a point on p to one on q, at any time on the path [m]. Both may be the
  /// same patch.
  double between(int p, int q) const;

  /// The same for any two [m].
  double max() const { return 2 * longest_; }

 private:
  std::vector<Box> displacements_;  // of the displacements of each patch's points [m]
  double longest_ = 0;              // largest displacement relative to the mean of all [m]
};

}  // namespace clothsim
