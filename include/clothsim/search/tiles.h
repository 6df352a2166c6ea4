#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "clothsim/geometry/distance_rows.h"
#include "clothsim/geometry/surface_pair.h"
#include "clothsim/search/patches.h"

namespace clothsim {

/// Pairs of features that two tiles have together, by number. A tile's corners are its own point
/// and those to the right, across and above; see Patch.
class TileFeatures {
 public:
  enum : std::size_t { corners = 4 };
  enum : std::size_t { points = 4 };  // pairs of a point and a triangle come first, then of edges
  enum : std::size_t { count = 13 };
  /// Ways from a tile's point to its corners, along rows and along columns.
  static constexpr std::array<std::array<int, 2>, corners> ways{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  static constexpr std::array<std::array<std::size_t, 3>, 2> triangles{{{0, 1, 2}, {0, 2, 3}}};
  static constexpr std::array<std::array<std::size_t, 2>, 3> edges{{{0, 1}, {0, 3}, {0, 2}}};

  /// Corners that are farthest along what a pair takes of tile a and of tile b.
  static constexpr std::array<std::size_t, count> of_a{0, 0, 2, 2, 1, 1, 1, 3, 3, 3, 2, 2, 2};
  static constexpr std::array<std::size_t, count> of_b{2, 2, 0, 0, 1, 3, 2, 1, 3, 2, 1, 3, 2};

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

/// Where tiles are, side by side and in single precision, so that as many pairs as a patch has
/// tiles are measured at once; see DistanceRows. rounding() is that of their places.
class TileShapes {
 public:
  static constexpr std::size_t tiles = DistanceRows::size;  // of a patch
  static_assert(tiles == Patch::side * Patch::side);
  static constexpr float infinity = std::numeric_limits<float>::infinity();

  using Row = DistanceRows::Row;
  using Features = std::array<Row, TileFeatures::count>;
  using Corners = DistanceRows::Hulls;
  /// Of up to as many pairs of tiles.
  struct Distances {
    Features values;                               // [m]
    std::array<Row, TileFeatures::points> within;  // least barycentric coordinate of the point
  };

  TileShapes(const Cloth&, std::shared_ptr<const std::vector<Patch>>);

  /// Takes the tiles of a patch as they are at `positions` [m, N x 3]: the same for all that are
  /// compared. What a tile at the last row or column lacks lies along that.
  void update(int patch, const Points& positions);

  /// What rounding of places does to a distance between two patches [m].
  float rounding(int patch, int other) const;

  /// A number for each pair i * tiles + j of tiles of two patches.
  using PairValues = std::array<float, tiles * tiles>;

  /// Pairs of tiles that may be within a `gap` beyond the nearest that they may come, or within
  /// `least` [m], of a patch with itself each once.
  struct Near {
    std::array<int, tiles * tiles> pairs;
    std::size_t count;
    float rest;      // the others are so far from each other [m],
    float rest_gap;  // beyond the nearest they may come
  };
  void look(int patch, int other, const PairValues& nearest, float gap, float least, Near&) const;

  /// Distances of the features of `count` of these pairs, up to `tiles`; the last one fills up.
  void measure(int patch, int other, const int* pairs, std::size_t count, Distances&) const;

 private:
  bool exists(int patch, std::size_t tile) const {
    return (*patches_)[static_cast<std::size_t>(patch)].tiles[tile] != Patch::none;
  }

  int columns_;
  int rows_;
  std::shared_ptr<const std::vector<Patch>> patches_;
  std::vector<Corners> corners_;  // by patch [m]
  std::vector<float> roundings_;  // by patch [m]
};

}  // namespace clothsim
