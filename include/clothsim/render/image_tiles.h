#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>

#include "clothsim/render/camera.h"

namespace clothsim {

/// Box around the part of a triangle beyond the near plane, as a camera sees it [pixel]. Corners
/// are those in the optical frame [m]. Empty: the triangle is before the plane.
Eigen::AlignedBox2d seen_box(const Camera&, const std::array<Vector3, 3>& triangle);

/// Divides a camera's image into tiles. What is in different tiles has no common pixel.
class ImageTiles {
 public:
  /// Tiles of the columns [left, right) and the rows [top, bottom).
  struct Block {
    std::int16_t left, right, top, bottom;

    bool empty() const { return left >= right || top >= bottom; }
  };

  /// About `number` square tiles, none smaller than a pixel.
  ImageTiles(const Camera&, std::size_t number);

  int num_tiles() const { return columns_ * rows_; }

  /// Number of the tile with a pixel of the image.
  int tile_at(const Eigen::Vector2d& pixel) const;

  /// Tiles with a part of a box [pixel].
  Block covered(const Eigen::AlignedBox2d& box) const;

  /// Calls visit(tile) for the numbers of a block's tiles.
  template <class Visit>
  void for_each(const Block& block, const Visit& visit) const {
    for (int row = block.top; row < block.bottom; ++row)
      for (int column = block.left; column < block.right; ++column) visit(row * columns_ + column);
  }

 private:
  double side_;  // of a tile [pixel]
  int columns_, rows_;
};

}  // namespace clothsim
