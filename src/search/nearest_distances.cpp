#include "clothsim/search/nearest_distances.h"

#include <algorithm>
#include <cmath>

namespace clothsim {
namespace {

bool share_a_point(const SurfacePair& pair) {
  const auto second = pair.points.begin() + (pair.edges() ? 2 : 1);
  return std::find_first_of(pair.points.begin(), second, second, pair.points.end()) != second;
}

}  // namespace

NearestDistances::NearestDistances(const Cloth& cloth)
    : last_(cloth.columns - 1, cloth.rows - 1), contact_(2 * cloth.thickness) {
  for (int i = 0; i < cloth.num_points(); ++i) {
    places_.emplace_back(i % cloth.columns, i / cloth.columns);
  }
  const Points& x = cloth.rest_positions;
  const Eigen::Vector2d spacing((x.row(1) - x.row(0)).norm(),
                                (x.row(cloth.columns) - x.row(0)).norm());
  // Farther on both are as far apart as they ever need to be, or not on the cloth.
  const double far = std::ceil(contact_ / (neighbour_share * spacing.minCoeff())) + 2;
  const Eigen::Vector2i most_way = last_.cast<double>().cwiseMin(far).cast<int>();
  fill_features(spacing, most_way);
  fill_tiles(most_way);
}

void NearestDistances::fill_features(const Eigen::Vector2d& spacing,
                                     const Eigen::Vector2i& most_way) {
  // A grid that has all these ways from the tile in its middle.
  const int columns = 2 * most_way.x() + 2, rows = 2 * most_way.y() + 2;
  const int middle = most_way.y() * columns + most_way.x();
  Points grid = Points::Zero(columns * rows, 3);
  for (int i = 0; i < columns * rows; ++i) {
    const Eigen::Vector2i way = Eigen::Vector2i(i % columns, i / columns) - most_way;
    grid.block<1, 2>(i, 0) = way.cast<double>().cwiseProduct(spacing).transpose();
  }
  Features beyond;
  beyond.fill(contact_);
  least_ = edge_share * contact_;
  features_ = {most_way, beyond, [&](const Eigen::Vector2i& way) {
                 Features of = beyond;
                 for (std::size_t k = 0; k < TileFeatures::count; ++k) {
                   const int tile = middle + way.y() * columns + way.x();
                   const SurfacePair pair = TileFeatures(columns).pair(middle, tile, k);
                   of[k] = std::min(contact_, neighbour_share * separation(pair, grid).distance);
                   if (share_a_point(pair)) of[k] = -1;
                   if (of[k] >= 0) least_ = std::min(least_, of[k]);
                 }
                 return of;
               }};
}

void NearestDistances::fill_tiles(const Eigen::Vector2i& most_way) {
  const Eigen::Vector2i beyond = most_way + Eigen::Vector2i::Ones();
  for (const bool border : {false, true}) {
    const auto of_way = [&](const Eigen::Vector2i& way) {
      OfTiles of;
      for (std::size_t k = 0; k < TileFeatures::count; ++k) {
        const bool inside = k >= TileFeatures::points && !border;
        of[k] = static_cast<float>(
            std::min(features_.at(way)[k], (inside ? edge_share : 1) * contact_));
      }
      return of;
    };
    of_tiles_[border ? 1 : 0] = {most_way, of_way(beyond), of_way};
  }
  constexpr int side = Patch::side, tiles = TileShapes::tiles;
  const auto of_way = [&](const Eigen::Vector2i& way) {
    TileShapes::PairValues values;
    for (int k = 0; k < tiles * tiles; ++k) {
      const int i = k / tiles, j = k % tiles;
      const Eigen::Vector2i tile(j % side - i % side, j / side - i / side);
      const OfTiles& of = of_tiles(side * way + tile, true);
      values[static_cast<std::size_t>(k)] = *std::max_element(of.begin(), of.end());
    }
    return values;
  };
  of_patches_ = {beyond / side + Eigen::Vector2i::Ones(), of_way(2 * beyond), of_way};
}

double NearestDistances::of(const SurfacePair& pair) const {
  // A triangle's first corner is that of its cell.
  const auto& [a, b, c, d] = pair.points;
  if (!pair.edges()) return features_.at(way(a, b))[static_cast<std::size_t>(pair.triangle % 2)];
  const auto direction = [this](int first, int second) -> std::size_t {
    const Eigen::Vector2i along = way(first, second);
    return along.y() == 0 ? 0 : along.x() == 0 ? 1 : 2;
  };
  const std::size_t number = TileFeatures::points + 3 * direction(a, b) + direction(c, d);
  const bool border = is_border(a, b) || is_border(c, d);
  return std::min(features_.at(way(a, c))[number], (border ? 1 : edge_share) * contact_);
}

/// Of an edge, by its points: both are on one line of the border.
bool NearestDistances::is_border(int first, int second) const {
  const Eigen::Vector2i &p = places_[static_cast<std::size_t>(first)],
                        &q = places_[static_cast<std::size_t>(second)];
  return (p.array() == q.array() && (p.array() == 0 || p.array() == last_.array())).any();
}

bool NearestDistances::lack(int a, int b, std::size_t number) const {
  const auto lacks = [this](int tile, std::size_t corner) {
    const auto& [along_row, along_column] = TileFeatures::ways[corner];
    const Eigen::Vector2i& place = places_[static_cast<std::size_t>(tile)];
    return place.x() + along_row > last_.x() || place.y() + along_column > last_.y();
  };
  // The corner across is the farthest that triangles have, the second one that edges do.
  if (number < TileFeatures::points) return lacks(number < 2 ? b : a, TileFeatures::across);
  const std::size_t edges = number - TileFeatures::points;
  return lacks(a, TileFeatures::edges[edges / 3][1]) || lacks(b, TileFeatures::edges[edges % 3][1]);
}

}  // namespace clothsim
