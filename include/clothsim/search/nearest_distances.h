#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "clothsim/geometry/surface_pair.h"
#include "clothsim/model/cloth.h"
#include "clothsim/search/tiles.h"

namespace clothsim {

/// What is told by the way from one place of a grid to another, along columns and rows: farther on
/// than `most` the same as there.
template <typename Value>
class ByWay {
 public:
  ByWay() = default;
  template <typename Make>
  ByWay(const Eigen::Vector2i& most, const Make& make) : most_(most) {
    for (int row = -most.y(); row <= most.y(); ++row) {
      for (int column = -most.x(); column <= most.x(); ++column) {
        values_.push_back(make(Eigen::Vector2i(column, row)));
      }
    }
  }

  const Value& at(const Eigen::Vector2i& way) const {
    const Eigen::Vector2i place = way.cwiseMax(-most_).cwiseMin(most_) + most_;
    return values_[static_cast<std::size_t>(place.y() * (2 * most_.x() + 1) + place.x())];
  }

 private:
  Eigen::Vector2i most_;
  std::vector<Value> values_;  // along rows
};

/// How near two features of a cloth may come: 2 * thickness, or where they are neighbours on the
/// cloth, a quarter of their distance at rest, so that it can fold sharply and yet not pass through
/// itself.
///
/// Two edges inside the cloth may come a share of that nearer. Where layers lie on each other their
/// points keep them 2 * thickness apart, and edges would only tell the same again; the share is
/// left to them where folds cross whose points miss each other. An edge of the border has no cloth
/// beside it that points could meet: it keeps the whole distance.
///
/// Points have no surface: those that are neighbours, with a rest distance below twice that of
/// contact, are left out. A fold between them has no room for a layer.
///
/// A grid looks the same from every cell, so the distances are kept by the way from one tile to the
/// other.
class NearestDistances {
 public:
  /// How near neighbours on the cloth may come, of their distance at rest.
  static constexpr double neighbour_share = 0.25;
  /// How near edges inside the cloth may come, of 2 * thickness: with all of it two thirds of the
  /// contacts of a pile are of edges, with this a tenth, and it comes to rest sooner.
  static constexpr double edge_share = 0.8;
  /// From where on points are no neighbours at rest, of the contact distance.
  static constexpr double apart_at_rest = 2;

  /// `stencils`: the pairs of features that count.
  explicit NearestDistances(const Cloth&,
                            const TileFeatures::Range& stencils = TileFeatures::of_surfaces);

  /// Of pair `number` of the features of tiles a and b [m]: below 0 where these share a point, or
  /// lie at the last row or column and lack what they need.
  double of(int a, int b, std::size_t number) const {
    return std::min(tiles_.at(way(a, b)).of[number], most_of(side(a, b, number), number));
  }
  /// Of all of them.
  using OfTiles = std::array<float, TileFeatures::count>;
  OfTiles of_tiles(int a, int b) const;

  /// Of those that count of the tiles of two patches, by their first tiles: the most of each pair
  /// of tiles [m].
  const TileShapes::PairValues& of_patches(int first, int second) const {
    return of_patches_.at(way(first, second) / Patch::side);
  }
  std::size_t points() const { return places_.size(); }
  bool at_border(int point) const { return sides_[static_cast<std::size_t>(point)][0] == border; }

  /// The most and the least of any two, and the least distance at rest of any that share no point:
  /// of a point and the long side of a triangle, as of two diagonals side by side [m].
  double most() const { return 2 * thickness_; }
  double least() const { return std::min(edge_share * most(), neighbour_share * least_at_rest()); }
  double least_at_rest() const { return spacing_.prod() / spacing_.norm(); }

  /// Of the points at rest, along rows and along columns [m].
  const Eigen::Vector2d& spacing() const { return spacing_; }

 private:
  /// Where on the cloth lies what a tile has from its point to a corner.
  enum Side : unsigned char { inside, border, beyond };
  /// Of two tiles by the way between them, as if at the border, and inside.
  struct Tiles {
    std::array<double, TileFeatures::count> of;
    OfTiles inside;
  };

  Eigen::Vector2i way(int from, int to) const {
    return places_[static_cast<std::size_t>(to)] - places_[static_cast<std::size_t>(from)];
  }
  Side side(int a, int b, std::size_t number) const {
    return std::max(sides_[static_cast<std::size_t>(a)][TileFeatures::of_a[number]],
                    sides_[static_cast<std::size_t>(b)][TileFeatures::of_b[number]]);
  }
  double most_of(Side side, std::size_t number) const {
    if (side == beyond) return -1;
    const bool edges = number >= TileFeatures::points && number < TileFeatures::own_points;
    return edges && side == inside ? edge_share * most() : most();
  }
  Tiles make_tiles(const Eigen::Vector2i& way) const;
  TileShapes::PairValues make_patches(const Eigen::Vector2i& way) const;

  TileFeatures::Range stencils_;
  double thickness_;
  Eigen::Vector2d spacing_;
  std::vector<Eigen::Vector2i> places_;                         // of points: column and row
  std::vector<std::array<Side, TileFeatures::corners>> sides_;  // of tiles
  ByWay<Tiles> tiles_;
  ByWay<TileShapes::PairValues> of_patches_;
};

}  // namespace clothsim
