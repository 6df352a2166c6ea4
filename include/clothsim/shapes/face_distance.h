#pragma once

#include "clothsim/shapes/shape.h"

namespace clothsim {

/// Distance between a solid and a triangle in the solid's own frame; empty where it is more than
/// `reach` [m]. A plane bounds its corners alone: always empty.
///
/// Out of a polyhedron the shortest way is along the normal of one of its faces or of the triangle,
/// or square to an edge of each (Gottschalk, Lin & Manocha 1996, "OBBTree"); round shapes are a
/// point or a line with a radius.
std::optional<FaceDistance> face_distance(const Shape&, const Triangle&, double reach);

/// Where a line of the shape, an edge of a box or the axis of a capsule, comes as near to the edges
/// of a triangle, between their ends: distances along the normal of `nearest`, by edge, each from
/// corner i to i + 1. A triangle that lies on such a line touches it at two of them.
std::array<std::optional<FaceDistance>, 3> edges_along(const Shape&, const Triangle&,
                                                       const FaceDistance& nearest, double reach);

/// False where, within `reach` [m], the triangle can touch the shape with nothing but its corners,
/// as on the middle of a box's face or far away. Quick.
bool touches_between_corners(const Shape&, const Triangle&, double reach);

/// False where that is so of all triangles in the box. Quicker.
bool touches_between_corners(const Shape&, const Box&, double reach);

}  // namespace clothsim
