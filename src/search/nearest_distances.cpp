#include "clothsim/search/nearest_distances.h"

#include <algorithm>
#include <cmath>

namespace clothsim {
namespace {

/// Ways along an edge of each direction.
const std::array<Eigen::Vector2i, 3> edge_ways{Eigen::Vector2i(1, 0), {0, 1}, {1, 1}};

/// Corners of both triangles of a cell.
const std::array<std::array<Eigen::Vector2i, 3>, 2> corners{
    {{Eigen::Vector2i(0, 0), {1, 0}, {1, 1}}, {Eigen::Vector2i(0, 0), {1, 1}, {0, 1}}}};

/// Has feature pair k of a tile and one so far on the same point twice?
bool share_a_point(std::size_t k, int columns, int rows) {
  if (std::max(std::abs(columns), std::abs(rows)) > 2) return false;
  constexpr int width = 10;  // of a grid that has both
  const SurfacePair pair =
      TileFeatures(width).pair(width * width, width * (width + rows) + columns, k);
  const auto second = pair.points.begin() + (pair.edges() ? 2 : 1);
  return std::find_first_of(pair.points.begin(), second, second, pair.points.end()) != second;
}

}  // namespace

NearestDistances::Table::Table(const Eigen::Vector2i& most_way)
    : most(most_way),
      values(static_cast<std::size_t>(2 * most.x() + 1) *
             static_cast<std::size_t>(2 * most.y() + 1)) {}

std::size_t NearestDistances::Table::place(int columns, int rows) const {
  const auto width = static_cast<std::size_t>(2 * most.x() + 1);
  return static_cast<std::size_t>(rows + most.y()) * width +
         static_cast<std::size_t>(columns + most.x());
}

double NearestDistances::Table::at(int columns, int rows, double beyond) const {
  if (std::abs(columns) > most.x() || std::abs(rows) > most.y()) return beyond;
  return values[place(columns, rows)];
}

NearestDistances::NearestDistances(const Cloth& cloth)
    : point_columns_(cloth.columns), contact_(2 * cloth.thickness) {
  const Points& x = cloth.rest_positions;
  spacing_ = {(x.row(1) - x.row(0)).norm(), (x.row(cloth.columns) - x.row(0)).norm()};
  for (int i = 0; i < cloth.num_points(); ++i) {
    point_places_.emplace_back(i % cloth.columns, i / cloth.columns);
    const bool ends_row = point_places_.back().x() == cloth.columns - 1;
    const bool ends_column = point_places_.back().y() == cloth.rows - 1;
    const bool begins_row = point_places_.back().x() == 0, begins_column = i < cloth.columns;
    borders_.push_back(static_cast<unsigned char>(ends_row | ends_column << 1 | begins_row << 2 |
                                                  begins_column << 3));
  }
  fill_features();
  fill_tiles();
}

double NearestDistances::distance(bool edges, const std::array<Eigen::Vector2i, 4>& points) const {
  Points x = Points::Zero(4, 3);
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector2i& p = points[static_cast<std::size_t>(k)];
    x.block<1, 2>(k, 0) = p.cast<double>().cwiseProduct(spacing_).transpose();
  }
  const double rest =
      separation({edges ? SurfacePair::no_triangle : 0, {0, 1, 2, 3}, 0}, x).distance;
  return std::min(contact_, neighbour_share * rest);
}

void NearestDistances::fill_features() {
  // Beyond these ways both are as far apart as they ever need to be, or not on the cloth.
  const double far = std::ceil(contact_ / (neighbour_share * spacing_.minCoeff())) + 2;
  const Eigen::Vector2i most =
      (point_places_.back().array() + 2).cast<double>().min(far).cast<int>();
  const auto for_each_way = [&most](auto&& visit) {
    for (int rows = -most.y(); rows <= most.y(); ++rows) {
      for (int columns = -most.x(); columns <= most.x(); ++columns) visit(columns, rows);
    }
  };

  least_ = far_inside();
  const auto keep = [&](double& entry, bool edges, const std::array<Eigen::Vector2i, 4>& points) {
    entry = distance(edges, points);
    const auto second = points.begin() + (edges ? 2 : 1);
    const bool share_a_point =
        std::find_first_of(points.begin(), second, second, points.end()) != second;
    if (!share_a_point) least_ = std::min(least_, entry);
  };
  for (std::size_t t = 0; t < 2; ++t) {
    of_points_[t] = Table(most);
    for_each_way([&](int columns, int rows) {
      keep(of_points_[t].at(columns, rows), false,
           {Eigen::Vector2i(-columns, -rows), corners[t][0], corners[t][1], corners[t][2]});
    });
  }
  for (std::size_t e = 0; e < 3; ++e) {
    for (std::size_t f = 0; f < 3; ++f) {
      of_edges_[e][f] = Table(most);
      for_each_way([&](int columns, int rows) {
        const Eigen::Vector2i way(columns, rows);
        keep(of_edges_[e][f].at(columns, rows), true,
             {Eigen::Vector2i(0, 0), edge_ways[e], way, way + edge_ways[f]});
      });
    }
  }
}

void NearestDistances::fill_tiles() {
  const Eigen::Vector2i most = of_points_[0].most;
  for (int rows = -most.y(); rows <= most.y(); ++rows) {
    for (int columns = -most.x(); columns <= most.x(); ++columns) {
      OfTiles of;
      for (std::size_t k = 0; k < TileFeatures::count; ++k) {
        const bool edges = k >= TileFeatures::points;
        const std::size_t e = (k - TileFeatures::points) / 3, f = (k - TileFeatures::points) % 3;
        const int sign = k < 2 || edges ? 1 : -1;
        const Table& table = edges ? of_edges_[e][f] : of_points_[k % 2];
        of[k] = static_cast<float>(table.at(sign * columns, sign * rows, contact_));
        if (share_a_point(k, columns, rows)) of[k] = -1;
      }
      of_tiles_.push_back(of);
    }
  }
}

double NearestDistances::of(const SurfacePair& pair) const {
  const auto way = [&](int from, int to) -> Eigen::Vector2i {
    return point_places_[static_cast<std::size_t>(to)] -
           point_places_[static_cast<std::size_t>(from)];
  };
  if (!pair.edges()) {  // a triangle's first corner is that of its cell
    const Eigen::Vector2i d = way(pair.points[0], pair.points[1]);
    return of_points_[static_cast<std::size_t>(pair.triangle % 2)].at(d.x(), d.y(), contact_);
  }
  const auto direction = [&](int first, int second) -> std::size_t {
    return second - first == 1 ? 0 : second - first == point_columns_ ? 1 : 2;
  };
  const std::size_t e = direction(pair.points[0], pair.points[1]);
  const std::size_t f = direction(pair.points[2], pair.points[3]);
  const Eigen::Vector2i d = way(pair.points[0], pair.points[2]);
  const bool border =
      is_border(pair.points[0], pair.points[1]) || is_border(pair.points[2], pair.points[3]);
  return std::min(of_edges_[e][f].at(d.x(), d.y(), contact_), far_edges(border));
}

/// Of an edge, by its points: both are on one line of the border.
bool NearestDistances::is_border(int first, int second) const {
  return (borders_[static_cast<std::size_t>(first)] & borders_[static_cast<std::size_t>(second)]) !=
         0;
}

}  // namespace clothsim
