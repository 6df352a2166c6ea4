#pragma once

#include <array>
#include <cstddef>
#include <cstdlib>
#include <vector>

#include "clothsim/geometry/surface_pair.h"
#include "clothsim/model/cloth.h"
#include "clothsim/search/tiles.h"

namespace clothsim {

/// What is told by the way from one place of a grid to another, along rows and columns.
template <typename Value>
class ByWay {
 public:
  ByWay() = default;
  /// make(way) up to the `most` along both, and `beyond`.
  template <typename Make>
  ByWay(const Eigen::Vector2i& most, const Value& beyond, const Make& make)
      : most_(most), values_{beyond} {
    for (int row = -most.y(); row <= most.y(); ++row) {
      for (int column = -most.x(); column <= most.x(); ++column) {
        values_.push_back(make(Eigen::Vector2i(column, row)));
      }
    }
  }

  const Value& at(const Eigen::Vector2i& way) const {
    const bool is_beyond = std::abs(way.x()) > most_.x() || std::abs(way.y()) > most_.y();
    const Eigen::Vector2i place = way + most_;
    const int number = 1 + place.y() * (2 * most_.x() + 1) + place.x();
    return values_[is_beyond ? 0 : static_cast<std::size_t>(number)];
  }

 private:
  Eigen::Vector2i most_;
  std::vector<Value> values_;  // beyond, then along rows
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
/// A grid looks the same from every cell, so the distances are kept by the way from one tile to the
/// other.
class NearestDistances {
 public:
  /// How near neighbours on the cloth may come, of their distance at rest.
  static constexpr double neighbour_share = 0.25;
  /// How near edges inside the cloth may come, of 2 * thickness: with all of it two thirds of the
  /// contacts of a pile are of edges, with this a tenth, and it comes to rest sooner.
  static constexpr double edge_share = 0.8;

  explicit NearestDistances(const Cloth&);

  /// Of a pair [m].
  double of(const SurfacePair&) const;

  /// Of the features that tiles have together on a way from one to the other [m]: below 0 where
  /// they share a point. `border`: one tile is there, and so may edges be.
  using OfTiles = std::array<float, TileFeatures::count>;
  const OfTiles& of_tiles(const Eigen::Vector2i& way, bool border) const {
    return of_tiles_[border ? 1 : 0].at(way);
  }
  /// Of any features of the tiles of two patches, by their first tiles: the most of each pair [m].
  const TileShapes::PairValues& of_patches(int first, int second) const {
    return of_patches_.at(way(first, second) / Patch::side);
  }
  /// From one point, or a tile by its point, to another.
  Eigen::Vector2i way(int from, int to) const {
    return places_[static_cast<std::size_t>(to)] - places_[static_cast<std::size_t>(from)];
  }
  bool at_border(int point) const {
    const Eigen::Vector2i& place = places_[static_cast<std::size_t>(point)];
    return place.x() == 0 || place.y() == 0 || place.x() == last_.x() || place.y() == last_.y();
  }
  /// Do tiles a and b at the last row or column lack what pair `number` of their features needs?
  bool lack(int a, int b, std::size_t number) const;

  /// The most and the least of any two [m].
  double most() const { return contact_; }
  double least() const { return least_; }

 private:
  using Features = std::array<double, TileFeatures::count>;

  void fill_features(const Eigen::Vector2d& spacing, const Eigen::Vector2i& most_way);
  void fill_tiles(const Eigen::Vector2i& most_way);
  bool is_border(int first, int second) const;

  Eigen::Vector2i last_;                 // column and row
  std::vector<Eigen::Vector2i> places_;  // of points: column and row
  double contact_;
  double least_;
  ByWay<Features> features_;                // as if at the border
  std::array<ByWay<OfTiles>, 2> of_tiles_;  // inside, and there
  ByWay<TileShapes::PairValues> of_patches_;
};

}  // namespace clothsim
