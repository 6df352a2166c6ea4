#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/search/surface_pair.h"
#include "clothsim/search/tiles.h"

namespace clothsim {

/// How near two features of a cloth may come: 2 * thickness, or where they are neighbours on the
/// cloth, a quarter of their distance at rest, so that it can fold sharply and yet not pass through
/// itself.
///
/// Two edges inside the cloth may come a share of that nearer. Where layers lie on each other their
/// points keep them 2 * thickness apart, and edges would only tell the same again; the share is
/// left to them where folds cross whose points miss each other. An edge of the border has no cloth
/// beside it that points could meet: it keeps the whole distance.
///
/// A grid looks the same from every cell, so the distances are kept by the way from one feature to
/// the other.
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
  /// Of what two tiles have together, from a lower bound that holds for any pair so far from each
  /// other on the grid; of edges of the border up to far() [m]. Below 0 where they share a point.
  /// `columns`, `rows`: the way from the first tile to the second, see are_neighbours().
  using OfTiles = std::array<float, TileFeatures::count>;
  const OfTiles& of_tiles(int columns, int rows) const {
    return of_tiles_[of_points_[0].place(columns, rows)];
  }
  /// So near on the grid that they may come nearer than others.
  bool are_neighbours(int columns, int rows) const {
    return std::abs(columns) <= of_points_[0].most.x() && std::abs(rows) <= of_points_[0].most.y();
  }
  /// Of two that are no neighbours: the most, and of edges inside the cloth [m].
  double far() const { return contact_; }
  double far_inside() const { return far_edges(false); }
  /// Has a tile an edge of the border?
  bool has_border(int tile) const { return borders_[static_cast<std::size_t>(tile)] != 0; }
  /// The least of any two [m].
  double least() const { return least_; }

 private:
  /// By way along rows and along columns, from -most to most.
  struct Table {
    explicit Table(const Eigen::Vector2i& most = {0, 0});

    Eigen::Vector2i most;
    std::vector<double> values;
    std::size_t place(int columns, int rows) const;
    double& at(int columns, int rows) { return values[place(columns, rows)]; }
    double at(int columns, int rows, double beyond) const;
  };

  void fill_features();
  void fill_tiles();
  double distance(bool edges, const std::array<Eigen::Vector2i, 4>& points) const;
  double far_edges(bool border) const { return (border ? 1 : edge_share) * contact_; }
  bool is_border(int first, int second) const;

  int point_columns_;
  std::vector<Eigen::Vector2i> point_places_;  // column and row
  std::vector<unsigned char> borders_;         // that points lie on, a bit for each
  Eigen::Vector2d spacing_;                    // along rows and columns [m]
  double contact_;
  double least_;
  std::array<Table, 2> of_points_;                // by triangle of its cell
  std::array<std::array<Table, 3>, 3> of_edges_;  // by direction of either: row, column, diagonal
  std::vector<OfTiles> of_tiles_;                 // by way
};

}  // namespace clothsim
