#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/search/surface_pair.h"

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
  /// The most over what two cells own, see SurfaceMesh: over their edges, or all [m].
  double most_of_cells(int cell, int other) const;
  double most_of_edges(int cell, int other) const {
    return std::min(most_of_cells(cell, other), far_edges(has_border(cell) || has_border(other)));
  }
  /// The least of two that are no neighbours [m].
  double least_far() const { return far_edges(false); }
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
  void fill_cells();
  double distance(bool edges, const std::array<Eigen::Vector2i, 4>& points) const;
  double far_edges(bool border) const { return (border ? 1 : edge_share) * contact_; }
  bool is_border(int first, int second) const;
  bool has_border(int cell) const;

  int point_columns_;
  std::vector<Eigen::Vector2i> point_places_;  // column and row
  std::vector<Eigen::Vector2i> cell_places_;
  std::vector<unsigned char> borders_;  // that points lie on, a bit for each
  Eigen::Vector2d spacing_;             // along rows and columns [m]
  double contact_;
  double least_;
  std::array<Table, 2> of_points_;                // by triangle of its cell
  std::array<std::array<Table, 3>, 3> of_edges_;  // by direction of either: row, column, diagonal
  Table of_cells_;
  Table of_first_cells_;  // where one is in the first row or column, with more points and edges
};

}  // namespace clothsim
