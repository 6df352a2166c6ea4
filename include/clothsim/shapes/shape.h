#pragma once

#include <variant>

#include "clothsim/shapes/capsule.h"
#include "clothsim/shapes/cuboid.h"
#include "clothsim/shapes/cylinder.h"
#include "clothsim/shapes/mesh_shape.h"
#include "clothsim/shapes/plane.h"
#include "clothsim/shapes/sphere.h"

namespace clothsim {

/// The closed list of shapes. Each has a name that scenes know it by, equality, whether it is
/// convex (what moves away from it does not come back), and members that the functions over all
/// shapes find by std::visit: the compiler asks for those that a new one lacks. Those of the same
/// name do what the function does.
/// - near_surface() is signed_distance() of (x, y, z), with the z of `side`: without branches, for
///   the loops that it is inlined into.
/// - entry() is the share of `way` after which entry_point() lies, over 1 where the way is too
///   short.
/// - visit_lines() visits the lines of edges_along() that support it along `normal`.
/// - may_touch() is touches_between_corners() of a box, and of a triangle where it is one's.
using Shape = std::variant<Sphere, Plane, Capsule, Cuboid, Cylinder, MeshShape>;

/// Distance from `point` to the surface, both in the shape's own frame. `side`: where the point
/// came from; a two-sided plane is solid beyond itself as seen from there. Where the nearest
/// surface is not one alone the normal is one of those possible: +z at the centre of a sphere, +x
/// on the axis of a capsule or a cylinder, the first axis of those nearest in a box.
Distance signed_distance(const Shape&, const Vector3& point, const Vector3& side);

/// Where a point that moves in a straight line `from` -> `to`, in the shape's own frame, comes
/// within `offset` [m] of the surface from outside; `from` where it is that near already and moves
/// in. Empty where it stays out or starts in the solid. Into a mesh it is found by steps of the
/// distance that is left (Hart 1996, "Sphere tracing"). A box and a cylinder are grown by the
/// offset without rounding their edges. A plane has no far side to come out of: always empty, its
/// signed distance tells all.
std::optional<Vector3> entry_point(const Shape&, const Vector3& from, const Vector3& to,
                                   double offset);

/// How far into the shape the nearest surface is still the one a point came through [m].
double safe_depth(const Shape&);

/// How far from the surface corners keep all of a flat triangle `offset` off it, where its edges
/// are no longer than `edge` (all in m); infinite where the surface has edges.
double corner_distance(const Shape&, double edge, double offset);

/// Radius about the origin of its own frame that holds the solid; infinite for a plane [m].
double bounding_radius(const Shape&);

}  // namespace clothsim
