#include "clothsim/search/nearest_distances.h"

#include <algorithm>
#include <cmath>

namespace clothsim {

namespace {

/// Along rows and along columns; where there is but one of them, as of the other.
Eigen::Vector2d spacing_of(const Cloth& cloth) {
  const auto to = [&](int point) -> double {
    return (row(cloth.rest_positions, point) - row(cloth.rest_positions, 0)).norm();
  };
  const int along = cloth.columns > 1 ? 1 : 0, up = cloth.rows > 1 ? cloth.columns : 0;
  return {to(along > 0 ? along : up), to(up > 0 ? up : along)};
}

}  // namespace

NearestDistances::NearestDistances(const Cloth& cloth, const TileFeatures::Range& stencils)
    : stencils_(stencils), thickness_(cloth.thickness), spacing_(spacing_of(cloth)) {
  const Eigen::Array2i last(cloth.columns - 1, cloth.rows - 1);
  for (int i = 0; i < cloth.num_points(); ++i) {
    const Eigen::Array2i from(i % cloth.columns, i / cloth.columns);
    places_.emplace_back(from);
    sides_.emplace_back();
    for (std::size_t corner = 0; corner < TileFeatures::corners; ++corner) {
      const Eigen::Array2i to =
          from + Eigen::Map<const Eigen::Array2i>(TileFeatures::ways[corner].data());
      const bool along = (from == to && (from == 0 || from == last)).any();
      sides_.back()[corner] = (to > last).any() ? beyond : along ? border : inside;
    }
  }
  // Farther on both are as far apart as they ever need to be, or not on the cloth.
  const double far = std::ceil(most() / (neighbour_share * spacing_.minCoeff())) + 2;
  const Eigen::Vector2i most_way = last.cast<double>().min(far).cast<int>();
  tiles_ = {most_way, [this](const Eigen::Vector2i& way) { return make_tiles(way); }};
  // Farther on none of their tiles are within that.
  of_patches_ = {most_way / Patch::side + Eigen::Vector2i::Constant(2),
                 [this](const Eigen::Vector2i& way) { return make_patches(way); }};
}

NearestDistances::Tiles NearestDistances::make_tiles(const Eigen::Vector2i& way) const {
  // Both in rows of two points.
  const int other = TileFeatures::corners;
  Points corners = Points::Zero(2 * other, 3);
  for (int i = 0; i < corners.rows(); ++i) {
    Eigen::Vector2i place(i % 2, i / 2 % 2);
    if (i >= other) place += way;
    corners.block<1, 2>(i, 0) = place.cast<double>().cwiseProduct(spacing_).transpose();
  }
  Tiles tiles;
  for (std::size_t k = 0; k < TileFeatures::count; ++k) {
    const double at_rest = separation(TileFeatures(2).pair(0, other, k), corners).distance;
    const bool share_a_point = at_rest < least_at_rest() / 2;
    tiles.of[k] = share_a_point ? -1 : std::min(most(), neighbour_share * at_rest);
    if (k == TileFeatures::own_points) tiles.of[k] = at_rest < apart_at_rest * most() ? -1 : most();
    tiles.inside[k] = static_cast<float>(std::min(tiles.of[k], most_of(inside, k)));
  }
  return tiles;
}

TileShapes::PairValues NearestDistances::make_patches(const Eigen::Vector2i& way) const {
  constexpr int side = Patch::side, tiles = TileShapes::tiles;
  TileShapes::PairValues values;
  for (int k = 0; k < tiles * tiles; ++k) {
    const int i = k / tiles, j = k % tiles;
    const Eigen::Vector2i tile(j % side - i % side, j / side - i / side);
    const auto& of = tiles_.at(side * way + tile).of;
    values[static_cast<std::size_t>(k)] = static_cast<float>(
        *std::max_element(of.data() + stencils_.begin, of.data() + stencils_.end));
  }
  return values;
}

NearestDistances::OfTiles NearestDistances::of_tiles(int a, int b) const {
  const Tiles& tiles = tiles_.at(way(a, b));
  if (!at_border(a) && !at_border(b)) return tiles.inside;
  OfTiles of;
  for (std::size_t k = 0; k < TileFeatures::count; ++k) {
    of[k] = static_cast<float>(std::min(tiles.of[k], most_of(side(a, b, k), k)));
  }
  return of;
}

}  // namespace clothsim
