#pragma once

#include <array>
#include <vector>

#include "clothsim/geometry/box_tree.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// A rectangle of the grid of a cloth: tiles as in TileFeatures.
struct Patch {
  static constexpr int side = 4;  // tiles along it
  static constexpr int none = -1;

  std::array<int, side * side> tiles;  // along rows, by their points; none beyond the cloth
  std::vector<int> points;             // of the tiles, those on the far borders too
};

/// Cuts the tiles of a cloth into patches, smaller ones at the last row and column.
std::vector<Patch> cut_into_patches(const Cloth&);

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
  double most() const { return 2 * longest_; }

 private:
  std::vector<Box> ways_;  // of the points of each patch [m]
  double longest_ = 0;     // way beyond the mean of all [m]
};

}  // namespace clothsim
