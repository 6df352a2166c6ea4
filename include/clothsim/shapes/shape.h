#pragma once

#include <memory>
#include <optional>
#include <variant>

#include "clothsim/model/types.h"

namespace clothsim {

/// Signed distance [m], negative inside, and its gradient, the unit normal into free space.
struct Distance {
  double value;
  Vector3 normal;
};

/// Ball about the origin of its own frame.
struct Sphere {
  static constexpr const char* name = "sphere";
  double radius = 0.2;  // [m]
};

/// Plane z = 0 of its own frame, normal +z. One-sided: all of z < 0 is solid. Two-sided: a sheet
/// that holds whatever is on either side.
struct Plane {
  static constexpr const char* name = "plane";
  bool two_sided = false;
};

/// All within `radius` of the z axis of its own frame from -length / 2 to length / 2.
struct Capsule {
  static constexpr const char* name = "capsule";
  double length = 0.4;  // [m] between the centres of its round ends
  double radius = 0.1;  // [m]
};

/// A box about the origin of its own frame, along its axes.
struct Cuboid {
  static constexpr const char* name = "box";
  Vector3 size{0.4, 0.4, 0.4};  // [m]
};

/// All within `radius` of the z axis of its own frame, with flat ends at -length / 2 and length
/// / 2.
struct Cylinder {
  static constexpr const char* name = "cylinder";
  double length = 0.4;  // [m]
  double radius = 0.1;  // [m]
};

inline bool operator==(const Sphere& a, const Sphere& b) { return a.radius == b.radius; }
inline bool operator==(const Plane& a, const Plane& b) { return a.two_sided == b.two_sided; }
inline bool operator==(const Capsule& a, const Capsule& b) {
  return a.length == b.length && a.radius == b.radius;
}
inline bool operator==(const Cuboid& a, const Cuboid& b) { return a.size == b.size; }
inline bool operator==(const Cylinder& a, const Cylinder& b) {
  return a.length == b.length && a.radius == b.radius;
}

struct MeshFile;

/// A solid of triangles in its own frame, grown by a padding with round edges.
struct MeshShape {
  static constexpr const char* name = "mesh";
  std::shared_ptr<const MeshFile> file;  // never null where distances are asked for
  double padding = 0;                    // [m]
};
inline bool operator==(const MeshShape& a, const MeshShape& b) {
  return a.file == b.file && a.padding == b.padding;
}

/// The closed list of shapes. What differs between them is an overload for each, found by
/// std::visit: the compiler asks for those that a new one lacks. Each has a name that scenes know
/// it by.
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
