#include "clothsim/geometry/tiling.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace clothsim {
namespace {

using Edge = std::array<int, 2>;

Edge edge_of(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

constexpr int nobody = -1;

/// Assigns points and edges of a mesh to tiles, each to the first tile that asks for it.
class Owners {
 public:
  explicit Owners(const SurfaceMesh& mesh)
      : is_free_(mesh.around_point.size(), true), at_border_(mesh.around_point.size(), false) {
    for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
      const auto& [a, b, c] = mesh.triangles[static_cast<std::size_t>(t)];
      for (const Edge& edge : {edge_of(a, b), edge_of(b, c), edge_of(c, a)}) {
        triangles_of_[edge].push_back(t);
      }
    }
    for (const auto& [edge, triangles] : triangles_of_) {
      for (const int end : edge) {
        if (triangles.size() == 1) at_border_[static_cast<std::size_t>(end)] = true;
      }
    }
  }

  bool is_free(int point) const { return is_free_[static_cast<std::size_t>(point)]; }
  const std::vector<int>& triangles_of(const Edge& edge) const { return triangles_of_.at(edge); }

  /// Assigns the tile its point and edges, as far as they are free.
  void give(Tiling::Tile& tile) {
    const auto p = static_cast<std::size_t>(tile.points[0]);
    tile.own[Tiling::own_point] = !is_free_[p]    ? Tiling::lacking
                                  : at_border_[p] ? Tiling::border
                                                  : Tiling::inside;
    is_free_[p] = false;
    for (std::size_t k = 0; k < Tiling::edges.size(); ++k) {
      const Edge edge = edge_of(tile.points[0], tile.points[Tiling::edges[k][1]]);
      const auto found = triangles_of_.find(edge);
      const bool has = found != triangles_of_.end() && given_.insert(edge).second;
      tile.own[Tiling::first_edge + k] = !has                        ? Tiling::lacking
                                         : found->second.size() == 1 ? Tiling::border
                                                                     : Tiling::inside;
    }
  }

  /// Edges that have no tile.
  std::vector<Edge> left() const {
    std::vector<Edge> edges;
    for (const auto& [edge, triangles] : triangles_of_) {
      if (given_.count(edge) == 0) edges.push_back(edge);
    }
    return edges;
  }

 private:
  std::vector<bool> is_free_;                      // by point
  std::vector<bool> at_border_;                    // by point
  std::map<Edge, std::vector<int>> triangles_of_;  // triangles
  std::set<Edge> given_;
};

/// The corner of a triangle that is not on an edge.
int across(const std::array<int, 3>& triangle, const Edge& edge) {
  return *std::find_if(triangle.begin(), triangle.end(),
                       [&](int point) { return point != edge[0] && point != edge[1]; });
}

}  // namespace

void Tiling::add(const Tile& tile) {
  const auto number = static_cast<int>(tiles_.size());
  if (tile.own[own_point] != lacking) of_point_[static_cast<std::size_t>(tile.points[0])] = number;
  for (std::size_t k = 0; k < triangles.size(); ++k) {
    if (tile.own[first_triangle + k] == lacking) continue;
    of_triangle_[static_cast<std::size_t>(tile.triangles[k])] = number;
  }
  tiles_.push_back(tile);
}

Tiling::Tiling(const SurfaceMesh& mesh)
    : of_point_(mesh.around_point.size(), nobody), of_triangle_(mesh.triangles.size(), nobody) {
  Owners owners(mesh);
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    if (of_triangle(t) != nobody) continue;
    const std::array<int, 3>& corners_of = mesh.triangles[static_cast<std::size_t>(t)];
    // Joined with the triangle beyond one of its edges, if that has no tile yet.
    Edge shared = edge_of(corners_of[0], corners_of[1]);
    int other = nobody;
    for (std::size_t k = 0; k < 3 && other == nobody; ++k) {
      const Edge edge = edge_of(corners_of[k], corners_of[(k + 1) % 3]);
      for (const int neighbour : owners.triangles_of(edge)) {
        if (neighbour == t || of_triangle(neighbour) != nobody) continue;
        other = neighbour;
        shared = edge;
        break;
      }
    }
    if (!owners.is_free(shared[0])) std::swap(shared[0], shared[1]);
    const int last = other == nobody
                         ? shared[1]
                         : across(mesh.triangles[static_cast<std::size_t>(other)], shared);
    Tile tile{{shared[0], across(corners_of, shared), shared[1], last}, {t, other}, {}};
    owners.give(tile);
    tile.own[first_triangle] = inside;
    tile.own[first_triangle + 1] = other == nobody ? lacking : inside;
    add(tile);
  }
  Tile alone{};
  alone.own[first_triangle] = alone.own[first_triangle + 1] = lacking;
  for (const Edge& edge : owners.left()) {
    alone.points = {edge[0], edge[1], edge[1], edge[1]};
    owners.give(alone);
    add(alone);
  }
  for (int i = 0; i < static_cast<int>(of_point_.size()); ++i) {
    if (of_point(i) != nobody) continue;
    alone.points = {i, i, i, i};
    owners.give(alone);
    add(alone);
  }
}

Tiling::Tiling(int columns, int rows)
    : of_point_(static_cast<std::size_t>(columns * rows)),
      of_triangle_(static_cast<std::size_t>(2 * (columns - 1) * (rows - 1))) {
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int i = row * columns + column, cell = i - row;  // one less in each row
      const bool last_column = column + 1 == columns, last_row = row + 1 == rows;
      const int along = last_column ? 0 : 1, up = last_row ? 0 : columns;
      const bool at_side = column == 0 || last_column, at_end = row == 0 || last_row;
      Tile tile{{i, i + along, i + along + up, i + up}, {2 * cell, 2 * cell + 1}, {}};
      const FeaturePlace cells = last_column || last_row ? lacking : inside;
      tile.own = {at_side || at_end ? border : inside,
                  last_column ? lacking
                  : at_end    ? border
                              : inside,
                  last_row  ? lacking
                  : at_side ? border
                            : inside,
                  cells,
                  cells,
                  cells};
      add(tile);
    }
  }
}

SurfacePair Tiling::pair(int a, int b, std::size_t number) const {
  const auto &p = at(a).points, &q = at(b).points;
  if (number == own_points) return {SurfacePair::no_triangle, {p[0], p[0], q[0], q[0]}, 0};
  if (number >= points) {
    const auto& [i, j] = edges[(number - points) / 3];
    const auto& [k, l] = edges[(number - points) % 3];
    return {SurfacePair::no_triangle, {p[i], p[j], q[k], q[l]}, 0};
  }
  if (number >= 2) return pair(b, a, number - 2);
  const auto& [i, j, k] = triangles[number];
  return {at(b).triangles[number], {p[0], q[i], q[j], q[k]}, 0};
}

}  // namespace clothsim
