#pragma once

#include <optional>
#include <type_traits>
#include <variant>

#include "clothsim/shapes/capsule.h"
#include "clothsim/shapes/cuboid.h"
#include "clothsim/shapes/cylinder.h"
#include "clothsim/shapes/mesh_shape.h"
#include "clothsim/shapes/plane.h"
#include "clothsim/shapes/sphere.h"

namespace clothsim {

/// The closed list of shapes. Each has a name for scenes, equality, `is_convex` (a point that moves
/// away from a convex shape does not come back), and members that the functions over all shapes
/// find by std::visit: the compiler reports those that a new shape lacks. A member does the same as
/// the function of its name.
/// - near_surface() is signed_distance() of (x, y, z), with the z of `side`: without branches, for
///   the loops that inline it.
/// - support(), of convex solids, is the function of that name; where an end or a line of a
///   cylinder's side lies farthest, its middle.
/// - entry() is the share of `displacement` after which entry_point() lies, over 1 where it is too
///   short.
/// - visit_lines() visits the lines of edges_along() that support the shape along `normal`.
/// - may_touch() is touches_between_corners() of a box, and of a triangle where one is given.
using Shape = std::variant<Sphere, Plane, Capsule, Cuboid, Cylinder, MeshShape>;

/// Distance from `point` to the surface, both in the shape's own frame. `side`: where the point
/// came from; a two-sided plane is solid beyond itself as seen from there. Where several points of
/// the surface are nearest, the normal is that of one of them: +z at the centre of a sphere, +x on
/// the axis of a capsule or a cylinder, the first of the axes with the nearest face in a box.
Distance signed_distance(const Shape&, const Vector3& point, const Vector3& side);

/// Where a point that moves in a straight line `from` -> `to`, in the shape's own frame, comes
/// within `offset` [m] of the surface from outside; `from` where it is that near already and moves
/// in. Empty where the point stays out or starts in the solid. For a mesh: by steps of the
/// remaining distance (Hart 1996, "Sphere tracing"). A box and a cylinder are grown by the offset
/// without rounding their edges. Always empty for a plane: it has no far side, so its signed
/// distance is enough.
std::optional<Vector3> entry_point(const Shape&, const Vector3& from, const Vector3& to,
                                   double offset);

/// Depth in the shape up to which the nearest surface is the one a point came through [m].
double safe_depth(const Shape&);

/// Distance of the corners from the surface that keeps all of a flat triangle `offset` off it,
/// where its edges are no longer than `edge` (all in m); infinite where the surface has edges.
double corner_distance(const Shape&, double edge, double offset);

/// Bounded and convex: all shapes but planes, and meshes, which may be either.
template <class AnyShape>
constexpr bool is_convex_solid_v =
    std::decay_t<AnyShape>::is_convex && !std::is_same_v<std::decay_t<AnyShape>, Plane>;

bool is_convex_solid(const Shape&);

/// A point of a convex solid that lies farthest along `direction`, unit; empty for other shapes.
std::optional<Vector3> support(const Shape&, const Vector3& direction);

/// Radius of a ball about the origin of its own frame that holds the solid; infinite for a plane
/// [m].
double bounding_radius(const Shape&);

}  // namespace clothsim
