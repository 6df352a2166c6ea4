#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "clothsim/geometry/surface_mesh.h"
#include "clothsim/geometry/surface_pair.h"

namespace clothsim {

/// A surface in tiles. A tile has up to four corners, and owns up to one point, three edges and two
/// triangles. Each point, edge and triangle of the surface belongs to exactly one tile.
///
/// A tile's own point is corner 0. Its edges go from there to corners 1, 3 and 2, its triangles
/// have corners 0, 1, 2 and 0, 2, 3. Where a tile lacks a feature, its corners there coincide with
/// others.
class Tiling {
 public:
  enum : std::size_t { corners = 4 };
  static constexpr std::array<std::array<std::size_t, 3>, 2> triangles{{{0, 1, 2}, {0, 2, 3}}};
  static constexpr std::array<std::array<std::size_t, 2>, 3> edges{{{0, 1}, {0, 3}, {0, 2}}};

  /// Features that a tile may own, by number.
  enum Own : std::size_t { own_point, first_edge, first_triangle = first_edge + 3, num_own = 6 };
  /// An edge of the border has a triangle on one side only; a point of the border has such an edge.
  enum FeaturePlace : unsigned char { inside, border, lacking };

  // Pairs of features of two tiles: point and triangle first, then edges, then both points.
  enum : std::size_t { points = 4, own_points = 13, count = 14 };
  /// Is a pair of features, by number, one of edges?
  static constexpr bool is_of_edges(std::size_t pair) {
    return pair >= points && pair < own_points;
  }
  /// Pairs from number `begin` up to number `end`.
  struct Range {
    std::size_t begin;
    std::size_t end;
    bool are_points() const { return begin == own_points; }
  };
  static constexpr Range of_surfaces{0, own_points};
  static constexpr Range of_points{own_points, count};
  /// The feature of tile a and of tile b in each pair.
  static constexpr std::array<std::size_t, count> of_a{{0, 0, 4, 5, 1, 1, 1, 2, 2, 2, 3, 3, 3, 0}};
  static constexpr std::array<std::size_t, count> of_b{{4, 5, 0, 0, 1, 2, 3, 1, 2, 3, 1, 2, 3, 0}};

  struct Tile {
    std::array<int, corners> points;
    std::array<int, 2> triangles;  // by number in the mesh; any where there is none
    std::array<FeaturePlace, num_own> own;
  };

  /// Tiles of any triangles: two neighbours each where possible, in no order.
  explicit Tiling(const SurfaceMesh&);

  /// Tiles of a grid, also of one row or column: each point has a tile of the same number, whose
  /// corners are the points to the right, across and above.
  Tiling(int columns, int rows);

  std::size_t num_points() const { return of_point_.size(); }
  const std::vector<Tile>& tiles() const { return tiles_; }
  const Tile& at(int tile) const { return tiles_[static_cast<std::size_t>(tile)]; }
  int of_point(int point) const { return of_point_[static_cast<std::size_t>(point)]; }
  int of_triangle(int triangle) const { return of_triangle_[static_cast<std::size_t>(triangle)]; }

  /// Pair `number` of tiles a and b, without `nearest`.
  SurfacePair pair(int a, int b, std::size_t number) const;

  /// A unique key for each pair, with bit 63 set.
  static std::uint64_t key(int a, int b, std::size_t number) {
    return std::uint64_t{1} << 63 | static_cast<std::uint64_t>(a) << 34 |
           static_cast<std::uint64_t>(b) << 4 | number;
  }

 private:
  void add(const Tile&);

  std::vector<Tile> tiles_;
  std::vector<int> of_point_;
  std::vector<int> of_triangle_;
};

}  // namespace clothsim
