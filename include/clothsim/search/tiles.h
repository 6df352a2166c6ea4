#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "clothsim/search/patches.h"
#include "clothsim/search/surface_pair.h"

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

  explicit TileFeatures(int columns) : columns_(columns) {}

  /// Feature pair `number` of tiles a and b, but for how near they may come.
  SurfacePair pair(int a, int b, std::size_t number) const;

 private:
  int point(int tile, std::size_t corner) const {
    return tile + ways[corner][0] + ways[corner][1] * columns_;
  }
  SurfacePair point_and_triangle(int of_point, int of_triangle, std::size_t number) const;

  int columns_;
};

/// Where tiles are, side by side and in single precision, so that sixteen pairs are measured at
/// once. Distances are never more than they are, but for rounding() of their places.
class TileShapes {
 public:
  static constexpr std::size_t tiles = Patch::side * Patch::side;  // of a patch, at most
  static constexpr std::size_t at_once = 16;
  static constexpr float far = 1e30F;  // as far away as what a tile lacks [m]

  using Row = std::array<float, at_once>;
  /// Of up to `at_once` pairs of tiles.
  struct Distances {
    std::array<Row, TileFeatures::count> values;   // [m]
    std::array<Row, TileFeatures::points> within;  // least barycentric coordinate of the point
  };

  TileShapes(const Cloth&, std::size_t num_patches);

  /// Where all tiles are seen from.
  void see_from(const Vector3& origin) { origin_ = origin; }

  /// Takes the tiles of a patch as they are at `positions` [m, N x 3].
  void update(int patch, const Patch& of, const Points& positions);

  /// What rounding of places does to a distance between two patches [m].
  float rounding(int patch, int other) const {
    return std::max(roundings_[static_cast<std::size_t>(patch)],
                    roundings_[static_cast<std::size_t>(other)]);
  }

  /// A number for each pair i * tiles + j of tiles of two patches.
  using PairValues = std::array<float, tiles * tiles>;

  /// Pairs of tiles that may be within a `gap` beyond the nearest that they may come, or within
  /// `least` [m], of a patch with itself each once.
  struct Near {
    std::array<int, tiles * tiles> pairs;
    std::size_t count = 0;
    float rest = far;      // the others are so far from each other [m],
    float rest_gap = far;  // beyond the nearest they may come
  };
  void look(int patch, int other, const PairValues& nearest, float gap, float least,
            Near& near) const;

  /// Distances of the features of `count` of these pairs, up to `at_once`.
  void measure(int patch, int other, const int* pairs, std::size_t count, Distances&) const;

 private:
  // By patch: corners, then the centre, each by axis; what a tile lacks: all triangles, the edge
  // to the right, and the one above.
  enum : std::size_t { axes = 3 };
  static constexpr std::size_t centre = TileFeatures::corners;
  static constexpr std::size_t first_lack = (TileFeatures::corners + 1) * axes;
  static constexpr std::size_t rows = first_lack + 3;

  const float* of(int patch) const {
    return values_.data() + static_cast<std::size_t>(patch) * rows * tiles;
  }

  int columns_;
  int rows_;
  Vector3 origin_ = Vector3::Zero();
  std::vector<float> values_;
  std::vector<float> roundings_;  // by patch [m]
  std::vector<char> exists_;      // whether a tile is none, by patch
};

}  // namespace clothsim
