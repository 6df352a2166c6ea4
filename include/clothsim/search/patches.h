#pragma once

#include <array>
#include <vector>

#include "clothsim/geometry/box_tree.h"
#include "clothsim/geometry/tiling.h"
#include "clothsim/model/types.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// Some tiles of a surface that lie together, on a grid by their places in a square along rows.
struct Patch {
  static constexpr int side = 4;  // tiles along it, on a grid
  static constexpr int none = -1;

  std::array<int, side * side> tiles;  // none where there are fewer
  std::vector<int> points;             // all corners of the tiles, each once
};

/// Of a grid: its rectangles along rows, smaller ones at the last row and column.
std::vector<Patch> cut_into_patches(const Tiling&, int columns, int rows);

/// Of any surface at `rest` [m, N x 3]: halves of halves, across where they are longest.
std::vector<Patch> cut_into_patches(const Tiling&, const Points& rest);

/// How patches move against each other while points go on straight ways.
class PatchMotions {
 public:
  /// The ways of the points of `patches` from one set of positions to another [m, N x 3, finite].
  void follow(const std::vector<Patch>& patches, const Points& from, const Points& to,
              const Workers& = {});

  /// The most by which a point on p comes nearer to one on q, at any time on the way [m]. Both may
  /// be the same patch.
  double between(int p, int q) const;

  /// That of any two [m].
  double max() const { return 2 * longest_; }

 private:
  std::vector<Box> ways_;  // of the points of each patch [m]
  double longest_ = 0;     // way beyond the mean of all [m]
};

}  // namespace clothsim
