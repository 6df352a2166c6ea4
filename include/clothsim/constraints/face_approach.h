#pragma once

#include <optional>

#include "clothsim/constraints/corners.h"
#include "clothsim/constraints/local_cloth.h"
#include "clothsim/constraints/triangle_blocks.h"
#include "clothsim/model/surface.h"
#include "clothsim/shapes/face_distance.h"

namespace clothsim {

/// Is a corner held in the solid? Then the triangle counts as held there.
bool is_held_inside(const Cloth&, const Corners&, const LocalCloth&);

// A triangle beside a held corner has to rest on the collider that it is pinned to, even if that
// corner is nearer to the surface than the offset. No impulse moves a held corner, so a contact
// near it needs large motion of the free corners.

/// Displacement [m] that raises a held corner of a triangle, in the shape's frame, along the normal
/// there to a distance of `offset` plus a hundredth of the longest edge from the surface; zero
/// beyond that distance.
Vector3 raise_of_held(const Shape&, double offset, const Triangle&, std::size_t corner);
/// The triangle with its held corners raised, for contacts. Corners that slip from their holders
/// are raised, too: otherwise the contact would jump as they slip or stick.
Triangle raised_at_held(const Shape&, const Cloth&, const Corners&, const Triangle&);

/// Depth [m] to which a contact beside a held corner may sink in where the free corners would move
/// over four times as fast as the contact does: up to a tenth of the longest edge at the held
/// corner.
double leeway(const Cloth&, const Corners&, const Triangle&, const CornerWeights&);

/// Distance of a triangle at a step's end, and whether it results from a sweep.
struct FaceApproach {
  std::optional<FaceDistance> distance;
  double before = 0;  // distance at the step's start, where negative [m]
  bool swept = false;
};

FaceApproach approach(const MovingCollider&, const Cloth&, std::size_t triangle, const LocalCloth&,
                      double margin);

/// A plane that has all of a convex solid below it, in the solid's frame. As the distance from the
/// solid is convex, its tangent at any point outside is one.
struct SupportingPlane {
  Vector3 normal{0, 0, 0};    // unit, away from the solid; 0: none is known
  double support = infinity;  // farthest that the solid reaches along the normal, at most [m]

  /// Lower bound on the distance of a triangle from the solid [m].
  double distance_of(const Triangle& t) const {
    return std::min({normal.dot(t[0]), normal.dot(t[1]), normal.dot(t[2])}) - support;
  }
};

/// The one below the triangle's nearest point, or `found` empty, the best of those below its
/// corners. None where the shape is not convex or `found` is not outside.
SupportingPlane supporting_plane(const Shape&, const Triangle&,
                                 const std::optional<FaceDistance>& found);

/// A triangle that was measured, in a collider's frame.
struct MeasuredTriangle {
  Triangle place{};             // [m]
  double distance = -infinity;  // from the surface, at least [m]
  SupportingPlane plane;        // between the surface and the triangle

  /// Lower bound on its distance after it has moved [m].
  double distance_at(const Triangle& t) const {
    return std::max(distance - longest_displacement(place, t), plane.distance_of(t));
  }
};

/// Calls visit(triangle, corners) where the triangle may touch within `margin` [m] with more than
/// its corners, or may have passed through. Triangles that have not may be left out by
/// is_far(triangle, corners).
template <class IsFar, class Visit>
void for_each_near(const Shape& shape, const Cloth& cloth, const TriangleBlocks& blocks,
                   const LocalCloth& local, double margin, IsFar is_far, Visit visit) {
  const double edge = std::isinf(local.edge) ? longest_edge(local.to, cloth.triangles) : local.edge;
  const double far = margin + edge / std::sqrt(3);  // distance of the nearest corner
  const double max_displacement = longest_row(local.to - local.from);
  const bool fast = max_displacement > safe_depth(shape);
  for (int b = 0; b < blocks.count(); ++b) {
    if (blocks.min(b, local.distance) > far + (fast ? max_displacement : 0)) continue;
    if (!fast && !touches_between_corners(shape, blocks.box(b, local.to), margin)) continue;
    for (std::size_t t = blocks.first_of(b); t < blocks.end_of(b); ++t) {
      const Corners& c = cloth.triangles[t];
      const bool may =
          fast || (!is_far(t, c) && touches_between_corners(shape, triangle_of(local.to, c), margin,
                                                            local.query(t, c)));
      if (!may) continue;
      if (is_held_inside(cloth, c, local)) continue;
      visit(static_cast<int>(t), c);
    }
  }
}

}  // namespace clothsim
