#pragma once

#include <array>
#include <vector>

#include "clothsim/geometry/intersections.h"
#include "clothsim/model/cloth.h"

namespace clothsim {

/// An edge between two points of a cloth, and the numbers of the triangles beside it; -1: none.
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
  double share;                   // along the edge, from its first point to the triangle
  std::array<double, 3> weights;  // of the triangle's corners at the crossing
  Vector3 normal;                 // of the triangle, unit length
};

/// Where two surfaces of a cloth cross: for each surface, the crossings of its edges with triangles
/// of the other.
using CrossingContour = std::array<std::vector<EdgeCrossing>, 2>;

/// The contours along which a cloth crosses itself at `positions` [m]; `pairs`: its triangles that
/// cross.
std::vector<CrossingContour> find_contours(const Cloth&, const SurfaceEdges&,
                                           const std::vector<TrianglePair>& pairs,
                                           const Points& positions);

}  // namespace clothsim
