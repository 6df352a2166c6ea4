#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "clothsim/geometry/surface_mesh.h"
#include "clothsim/search/surface_pair.h"

namespace clothsim {

/// The pairs of features that two cells of a cloth own, but for those that share a point.
///
/// A grid looks the same from every cell, so that a few lists, made once, serve all.
class FeaturePairs {
  /// Cells of the first row or column own more features than others.
  enum : std::size_t { kinds = 4 };
  /// Ways between cells that may share points, and one for all others.
  enum : std::size_t { ways = 10 };
  static constexpr std::size_t far_way = ways - 1;

 public:
  static constexpr std::size_t num_lists = kinds * kinds * ways;

  /// Two features, whose points are counted from the first points of their cells.
  struct Pair {
    std::array<int, 4> points;
    std::array<std::size_t, 4> of;  // whose they are: 0 the cell's, 1 the other's
    int triangle;                   // of a point and a triangle: the triangle's number in its cell
  };
  /// Points and triangles, and two edges: by SurfacePair::edges.
  using List = std::array<std::vector<Pair>, 2>;

  explicit FeaturePairs(const SurfaceMesh&);

  /// The number of the list of two cells, or of one with itself: each pair once.
  std::size_t number(int cell, int other) const {
    return (kind(cell) * kinds + kind(other)) * ways + way(cell, other);
  }
  const List& operator[](std::size_t number) const { return lists_[number]; }

  /// First point of a cell.
  int first_point(int cell) const { return place(cell).first_point; }

 private:
  struct Place {
    int column;
    int row;
    int first_point;
    int kind;
  };

  const Place& place(int cell) const { return places_[static_cast<std::size_t>(cell)]; }
  std::size_t kind(int cell) const { return static_cast<std::size_t>(place(cell).kind); }
  std::size_t way(int cell, int other) const;
  List list(const SurfaceMesh&, int cell, int other, bool apart) const;

  std::vector<Place> places_;  // by cell
  std::array<List, num_lists> lists_;
};

}  // namespace clothsim
