#pragma once

#include <algorithm>
#include <cmath>

#include "clothsim/constraints/contact_step.h"
#include "clothsim/constraints/corners.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/types.h"
#include "clothsim/shapes/face_distance.h"
#include "clothsim/shapes/moving_collider.h"

namespace clothsim {

/// Data that queries of a cloth to a mesh keep for the next ones; empty for other shapes.
struct MeshMemory {
  std::vector<Solid::Neighbourhood> points;    // by point
  std::vector<Solid::Surroundings> triangles;  // by triangle

  void fit(const MovingCollider&, const Cloth&);
};

/// A cloth in the frame of one collider.
struct LocalCloth {
  Points from;         // at a step's start [m]
  Points to;           // at its end [m]
  Points middle;       // where impulses act, as if they followed the collider from there on [m]
  Scalars distance;    // of `to` from the surface, see signed_distances() [m]
  double longest = 0;  // path from `from` to `to`, with the turn of the frame, at most [m]
  double edge = 0;     // bound on the edges of triangles [m]
  MeshMemory* mesh = nullptr;  // of the collider

  void place(const MovingCollider&, const Cloth&, const Points& start, const Points& end,
             MeshMemory&);
  void place_middle(const MovingCollider&, const ContactStep&, const Points& end);

  /// Both for some points of the cloth, without their distances. `bound`: on the paths of all [m].
  void place_points(const std::vector<int>& points, const MovingCollider&, const ContactStep&,
                    const Points& end, double bound, MeshMemory&);

  /// For queries about a triangle of the cloth.
  FaceQuery query(std::size_t triangle, const Corners&) const;
};

/// How contact keeps the triangles of a cloth out of a shape.
struct Clearance {
  double points;  // distance that points keep from the surface, the cloth's offset or more [m]
  bool faces;     // whether edges and faces have contacts of their own
};

/// Contacts of points alone suffice for a plane. They also do for a round or smooth shape that is
/// large relative to the triangles, with points at the distance that keeps the longest triangle off
/// the shape. Not between two colliders that leave no room (`pinched`), where such a distance would
/// take of it. `stretch`: of the most stretched spring; it counts where it is well over the strain
/// limit.
Clearance clearance(const Shape&, const Cloth&, double stretch = 0, bool pinched = false);

/// Longest edge of a triangle [m] where springs are stretched by at most a twentieth of their
/// length beyond the strain limit (a usual one where there is none), or by `stretch` if that is
/// more; infinite without triangles.
double longest_edge_within_limit(const Cloth&, double stretch);

/// Speed at which cloth leaves a collider that was put upon it, at most [m/s].
inline constexpr double recovery_speed = 2;

/// Cloth in a collider leaves at the speed of depth / recovery_time [s], at recovery_speed at most.
inline constexpr double recovery_time = 0.05;

/// Time [s] that recovery takes where only the cloth's weight opposes it. Where pins hold the cloth
/// in, recovery would never end: the speed halves for each such time more.
inline constexpr double recovery_patience = 0.5;

/// Factor on recovery_speed after a `time` [s] of recovery.
inline double recovery_factor_after(double time) {
  return std::min(1.0, std::exp2(1 - time / recovery_patience));
}

/// Speed [m/s] of recovery from a depth in a solid [m]: 0 outside, and too low for a leap where
/// other constraints have pushed in a point by a fraction of a millimetre.
inline double exit_speed(double depth) { return std::min(recovery_speed, depth / recovery_time); }

/// Distance by which loaded points may sink in from where contact keeps them [m].
inline constexpr double penetration_slop = surface_offset / 2;

/// Cloth may pass by a rim of a rigid body by this much nearer than contact keeps it [m].
inline constexpr double passing_depth = penetration_slop / 10;

/// Distance to which contact moves a point at `distance` from a surface that should keep `kept`
/// [m].
inline double raised(double distance, double kept) {
  return std::max(kept - penetration_slop, distance + overlap_share * (kept - distance));
}

/// Distance from a surface at a step's end, at least, of a point that leaves a solid: `before` at
/// the step's start, and moved by `displacement` (all in m).
inline double required_distance(double before, double offset, double displacement) {
  return std::min(offset, before + displacement);
}

}  // namespace clothsim
