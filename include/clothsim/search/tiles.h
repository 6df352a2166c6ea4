#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <memory>
#include <vector>

#include "clothsim/geometry/distance_rows.h"
#include "clothsim/geometry/tiling.h"
#include "clothsim/search/patches.h"

namespace clothsim {

/// Positions of tiles, side by side and in single precision, so that as many pairs as a patch has
/// tiles are measured at once; see DistanceRows. rounding() bounds the error of these positions.
class TileShapes {
 public:
  static constexpr std::size_t tiles = DistanceRows::size;  // of a patch
  static_assert(tiles == Patch::side * Patch::side);
  static constexpr float infinity = std::numeric_limits<float>::infinity();

  using Row = DistanceRows::Row;
  using Features = std::array<Row, Tiling::own_points>;
  using Corners = DistanceRows::Hulls;
  /// For up to as many pairs of tiles.
  struct Distances {
    Features values;                         // [m]
    std::array<Row, Tiling::points> within;  // least barycentric coordinate of the point
  };

  TileShapes(std::shared_ptr<const Tiling>, std::shared_ptr<const std::vector<Patch>>);

  /// Sets the tiles of a patch at `positions` [m, N x 3]: the same for all patches that are
  /// compared.
  void update(int patch, const Points& positions);

  /// Error of a distance between two patches by the rounding of positions [m].
  float rounding(int patch, int other) const;

  /// A number for each pair i * tiles + j of tiles of two patches.
  using PairValues = std::array<float, tiles * tiles>;

  /// Pairs of tiles that may be within their contact distance plus a `gap`, or within `min_range`
  /// [m]; for a patch with itself each once.
  struct Near {
    std::array<int, tiles * tiles> pairs;
    std::size_t count;
    float rest;      // least distance of the others [m],
    float rest_gap;  // less their contact distance [m]
  };
  void look(int patch, int other, const PairValues& nearest, float gap, float min_range,
            Near&) const;

  /// As look(), for the tiles' first corners alone.
  void look_at_points(int patch, int other, const PairValues& nearest, float gap, Near&) const;

  /// Distances of the surface features of `count` of these pairs, up to `tiles`; the last one fills
  /// the rest.
  void measure(int patch, int other, const int* pairs, std::size_t count, Distances&) const;

 private:
  template <typename Measure>
  void sort_out_near(int patch, int other, const PairValues& nearest, float gap, float min_range,
                     const Measure&, Near&) const;
  bool exists(int patch, std::size_t tile) const {
    return (*patches_)[static_cast<std::size_t>(patch)].tiles[tile] != Patch::none;
  }

  std::shared_ptr<const Tiling> tiling_;
  std::shared_ptr<const std::vector<Patch>> patches_;
  std::vector<Corners> corners_;  // by patch [m]
  std::vector<float> roundings_;  // by patch [m]
};

}  // namespace clothsim
