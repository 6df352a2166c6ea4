#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// Corners [m].
using Triangle = std::array<Vector3, 3>;

/// Displacement of the corner that moves farthest, and so of any point of a triangle, at most.
inline double longest_displacement(const Triangle& from, const Triangle& to) {
  double longest2 = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    longest2 = std::max(longest2, (to[k] - from[k]).squaredNorm());
  }
  return std::sqrt(longest2);
}

/// Two triangles of a cloth, a < b.
struct TrianglePair {
  int a;
  int b;
};

/// Do two triangles cross? They do where their interiors, without the edges, share a point and the
/// triangles are not coplanar: an edge of one passes through the other.
///
/// Touching is not crossing: a corner or an edge that ends on the other triangle, two edges that
/// meet, coplanar triangles that overlap. A triangle without area crosses nothing. Symmetric in
/// both triangles and in the order of their corners, and exact within the range of orientation().
/// Guigue & Devillers 2003, "Fast and robust triangle-triangle overlap test using orientation
/// predicates".
bool triangles_cross(const Triangle&, const Triangle&);

/// All pairs of triangles of the cloth that share no point of the grid and cross at `positions`
/// [m, N x 3, finite], sorted. A surface that passes through itself has such a pair, unless it does
/// so along edges alone.
std::vector<TrianglePair> find_intersections(const Cloth&, const Points& positions);

/// The number of these pairs.
int count_intersections(const Cloth&, const Points& positions);

}  // namespace clothsim
