#pragma once

#include "clothsim/shapes/shape.h"
#include "clothsim/shapes/solid.h"

namespace clothsim {

/// Data that queries about a triangle keep for the next ones, where the shape is a mesh; the
/// results are the same without.
struct FaceQuery {
  Solid::Surroundings* surroundings = nullptr;            // null: not kept
  std::array<Solid::Neighbourhood*, 3> neighbourhoods{};  // of the corners; null: not kept
};

/// Distance between a solid and a triangle in the solid's own frame; empty where it is more than
/// `reach` [m]. Always empty for a plane: there the triangle's corners are enough.
///
/// The shortest way out of a polyhedron is along the normal of one of its faces or of the triangle,
/// or perpendicular to an edge of each (Gottschalk, Lin & Manocha 1996, "OBBTree"); round shapes
/// are a point or a line with a radius.
std::optional<FaceDistance> face_distance(const Shape&, const Triangle&, double reach,
                                          const FaceQuery& query = {});

/// Where a line of the shape (an edge of a box, the axis of a capsule) comes as near to the edges
/// of a triangle, between their ends: distances along the normal of `nearest`, by edge, each from
/// corner i to i + 1. A triangle that lies on such a line touches it at two of its edges.
std::array<std::optional<FaceDistance>, 3> edges_along(const Shape&, const Triangle&,
                                                       const FaceDistance& nearest, double reach);

/// False where, within `reach` [m], the triangle can touch the shape with its corners alone, as on
/// the middle of a box's face, or not at all. Quick.
bool touches_between_corners(const Shape&, const Triangle&, double reach,
                             const FaceQuery& query = {});

/// False where the same holds for all triangles in the box. Quicker.
bool touches_between_corners(const Shape&, const Box&, double reach);

}  // namespace clothsim
