#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "clothsim/geometry/surface_pair.h"

namespace clothsim {

/// Each point of a grid has a tile: itself, its edges to the next points along the row, along the
/// column and across, and the two triangles between these. The last ones of a row or column lack
/// some of that. A tile's corners are its own point and those to the right, across and above.
///
/// These are the pairs of features that two tiles have together, by number. Of all tiles they are
/// all pairs of a cloth, each once. The last one is that of their own points.
class TileFeatures {
 public:
  enum : std::size_t { corners = 4 };
  enum : std::size_t { points = 4 };  // pairs of a point and a triangle come first, then of edges
  enum : std::size_t { own_points = 13 };
  enum : std::size_t { count = 14 };
  /// Numbers from one up to another.
  struct Range {
    std::size_t begin;
    std::size_t end;
  };
  static constexpr Range of_surfaces{0, own_points};
  static constexpr Range of_points{own_points, count};
  /// Ways from a tile's point to its corners, along rows and along columns.
  static constexpr std::array<std::array<int, 2>, corners> ways{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  static constexpr std::array<std::array<std::size_t, 3>, 2> triangles{{{0, 1, 2}, {0, 2, 3}}};
  static constexpr std::array<std::array<std::size_t, 2>, 3> edges{{{0, 1}, {0, 3}, {0, 2}}};

  /// Corners that are farthest along what a pair takes of tile a and of tile b.
  static constexpr std::array<std::size_t, count> of_a{{0, 0, 2, 2, 1, 1, 1, 3, 3, 3, 2, 2, 2, 0}};
  static constexpr std::array<std::size_t, count> of_b{{2, 2, 0, 0, 1, 3, 2, 1, 3, 2, 1, 3, 2, 0}};

  explicit TileFeatures(int columns) : columns_(columns) {}

  /// Feature pair `number` of tiles a and b, but for how near they may come.
  SurfacePair pair(int a, int b, std::size_t number) const;

  /// Another one for each, above all of 63 bits.
  static std::uint64_t key(int a, int b, std::size_t number) {
    return std::uint64_t{1} << 63 | static_cast<std::uint64_t>(a) << 34 |
           static_cast<std::uint64_t>(b) << 4 | number;
  }

 private:
  int point(int tile, std::size_t corner) const {
    return tile + ways[corner][0] + ways[corner][1] * columns_;
  }

  int columns_;
};

}  // namespace clothsim
