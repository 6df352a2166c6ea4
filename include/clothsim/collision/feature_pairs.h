#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "clothsim/collision/surface_mesh.h"
#include "clothsim/collision/surface_pair.h"

namespace clothsim {

/// The pairs of features that two cells of a cloth own, but for those that share a point.
///
/// A grid looks the same from every cell, so that a few lists, made once, serve all.
class FeaturePairs {
 public:
  /// Some pairs of one kind. Points are counted from the first points of their cells.
  struct Run {
    bool edges;                     // two edges, otherwise a point and a triangle
    std::array<std::size_t, 2> of;  // whose features a and b are: 0 the cell's, 1 the other's
    std::array<std::vector<int>, 4> points;
    std::vector<int> triangles;  // of a point and a triangle: the triangle's number in its cell

    std::size_t size() const { return points[0].size(); }
    /// Whose point k of a pair is.
    std::size_t of_point(std::size_t k) const { return of[edges ? k / 2 : k > 0]; }
  };
  using Runs = std::vector<Run>;

  explicit FeaturePairs(const SurfaceMesh&);

  /// Of two cells, or of one with itself: each pair once.
  const Runs& of(int cell, int other) const;
  /// Most pairs of one kind that two cells can have.
  static constexpr std::size_t most = 32;

  /// First points of both cells.
  std::array<int, 2> first_points(int cell, int other) const {
    return {place(cell).first_point, place(other).first_point};
  }

 private:
  /// Cells of the first row or column own more features than others.
  static constexpr std::size_t kinds = 4;
  /// Ways between cells that may share points, and one for all others.
  static constexpr std::size_t ways = 10;
  static constexpr std::size_t far_way = ways - 1;

  struct Place {
    int column;
    int row;
    int first_point;
    int kind;
  };

  const Place& place(int cell) const { return places_[static_cast<std::size_t>(cell)]; }
  std::size_t kind(int cell) const { return static_cast<std::size_t>(place(cell).kind); }
  std::size_t way(int cell, int other) const;
  Runs list(const SurfaceMesh&, int cell, int other, bool apart) const;

  std::vector<Place> places_;  // by cell
  std::array<std::array<std::array<Runs, ways>, kinds>, kinds> lists_;
};

}  // namespace clothsim
