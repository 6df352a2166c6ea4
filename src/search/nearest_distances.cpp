#include "clothsim/search/nearest_distances.h"

#include <cmath>

namespace clothsim {

NearestDistances::NearestDistances(const Cloth& cloth)
    : thickness_(cloth.thickness),
      spacing_((row(cloth.rest_positions, 1) - row(cloth.rest_positions, 0)).norm(),
               (row(cloth.rest_positions, cloth.columns) - row(cloth.rest_positions, 0)).norm()) {
  const Eigen::Array2i last(cloth.columns - 1, cloth.rows - 1);
  // Farther on both are as far apart as they ever need to be, or not on the cloth.
  const double far = std::ceil(most() / (neighbour_share * spacing_.minCoeff())) + 2;
  most_way_ = last.cast<double>().min(far).cast<int>();
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
  fill_features();
  fill_patches();
}

void NearestDistances::fill_features() {
  // Two tiles in rows of two points.
  const TileFeatures tiles(2);
  constexpr int a = 0, b = TileFeatures::corners;
  features_ = {
      most_way_, [&](const Eigen::Vector2i& way) {
        Points corners = Points::Zero(a + 2 * b, 3);
        for (int i = 0; i < corners.rows(); ++i) {
          const Eigen::Vector2i place = Eigen::Vector2i(i % 2, i / 2 % 2);
          corners.block<1, 2>(i, 0) =
              (i < b ? place : place + way).cast<double>().cwiseProduct(spacing_).transpose();
        }
        Features of;
        for (std::size_t k = 0; k < TileFeatures::count; ++k) {
          const double at_rest = separation(tiles.pair(a, b, k), corners).distance;
          const bool share_a_point = at_rest < least_at_rest() / 2;
          of[k] = share_a_point ? -1 : std::min(most(), neighbour_share * at_rest);
        }
        return of;
      }};
  inside_ = {most_way_, [&](const Eigen::Vector2i& way) {
               OfTiles of;
               for (std::size_t k = 0; k < TileFeatures::count; ++k) {
                 const double share = k < TileFeatures::points ? 1 : edge_share;
                 of[k] = static_cast<float>(std::min(features_.at(way)[k], share * most()));
               }
               return of;
             }};
}

void NearestDistances::fill_patches() {
  constexpr int side = Patch::side, tiles = TileShapes::tiles;
  // Farther on all their tiles are beyond the most way.
  const Eigen::Vector2i most = most_way_ / side + Eigen::Vector2i::Constant(2);
  of_patches_ = {most, [&](const Eigen::Vector2i& way) {
                   TileShapes::PairValues values;
                   for (int k = 0; k < tiles * tiles; ++k) {
                     const int i = k / tiles, j = k % tiles;
                     const Eigen::Vector2i tile(j % side - i % side, j / side - i / side);
                     const Features& of = features_.at(side * way + tile);
                     values[static_cast<std::size_t>(k)] =
                         static_cast<float>(*std::max_element(of.begin(), of.end()));
                   }
                   return values;
                 }};
}

NearestDistances::OfTiles NearestDistances::of_tiles(int a, int b) const {
  if (!at_border(a) && !at_border(b)) return inside_.at(way(a, b));
  OfTiles of;
  const Features& as_if = features_.at(way(a, b));
  for (std::size_t k = 0; k < TileFeatures::count; ++k) {
    of[k] = static_cast<float>(std::min(as_if[k], most_of(a, b, k)));
  }
  return of;
}

}  // namespace clothsim
