#pragma once

#include <array>
#include <vector>

#include "clothsim/geometry/intersections.h"
#include "clothsim/model/cloth.h"

namespace clothsim {

/// An edge between two points of a cloth, and the triangles beside it, by number; -1: none.
struct SurfaceEdge {
  std::array<int, 2> points;
  std::array<int, 2> triangles;
};

/// The edges of a cloth's triangles.
struct SurfaceEdges {
  explicit SurfaceEdges(const Cloth&);

  const SurfaceEdge& operator[](int edge) const { return edges[static_cast<std::size_t>(edge)]; }

  std::vector<SurfaceEdge> edges;
  std::vector<std::array<int, 3>> of_triangle;  // by triangle
  std::vector<std::vector<int>> of_point;       // by point
};

/// An edge that passes through a triangle.
struct EdgeCrossing {
  int edge;
  int triangle;
  double share;                   // of the edge, from its first point to the triangle
  std::array<double, 3> weights;  // of the triangle's corners there
  Vector3 normal;                 // of the triangle, of length 1
};

/// Where two surfaces of a cloth cross: by surface, the crossings of its edges with the other's
/// triangles.
using CrossingContour = std::array<std::vector<EdgeCrossing>, 2>;

/// The contours on which a cloth crosses itself at `positions` [m], by the `pairs` of its triangles
/// that cross there.
std::vector<CrossingContour> find_contours(const Cloth&, const SurfaceEdges&,
                                           const std::vector<TrianglePair>& pairs,
                                           const Points& positions);

}  // namespace clothsim
