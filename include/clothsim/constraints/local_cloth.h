#pragma once

#include <algorithm>
#include <cmath>

#include "clothsim/constraints/contact_step.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/types.h"
#include "clothsim/shapes/moving_collider.h"

namespace clothsim {

/// A cloth about one collider, in the collider's own frame.
struct LocalCloth {
  Points from;         // at a step's start [m]
  Points to;           // at its end [m]
  Points middle;       // where impulses act, as if it followed the collider from there on [m]
  Scalars distance;    // of `to` from the surface, see signed_distances() [m]
  double longest = 0;  // of the ways from `from` to `to`, however they bend as the frame turns [m]
  double edge = 0;     // no triangle's is longer [m]

  void place(const MovingCollider&, const Points& start, const Points& end);
  void place_middle(const MovingCollider&, const ContactStep&, const Points& end);
};

/// How contact keeps the triangles of a cloth out of a shape.
struct Clearance {
  double points;  // [m] that points keep from the surface, the cloth's offset or more
  bool faces;     // whether edges and faces have contacts of their own
};

/// A plane needs its points alone. So does a round or smooth shape that is large against the
/// triangles: corners that keep off it by as much as they would if the longest triangle lay on it
/// keep all of them off it. Not between two colliders that leave no room, where `pinched`: corners
/// that stand off would take of what there is. `stretch`: of the most stretched spring, which
/// counts where it is well over the strain limit.
Clearance clearance(const Shape&, const Cloth&, double stretch = 0, bool pinched = false);

/// Longest edge that a triangle may have where no spring is stretched by a twentieth of its length
/// beyond the strain limit, or a usual one where there is none, or by more than `stretch`; infinite
/// without triangles [m].
double longest_edge_within_limit(const Cloth&, double stretch);

/// Speed at which what a collider was put upon comes out of it [m/s].
inline constexpr double recovery_speed = 2;

/// Time [s] in which it comes out where that takes less than this speed.
inline constexpr double recovery_time = 0.05;

/// Time [s] in which it does, where nothing but the cloth's weight holds it. Where pins hold it, it
/// would be pushed for ever: so half as fast for each such time more.
inline constexpr double recovery_patience = 0.5;

/// How much of that speed is left after a `time` [s] of it.
inline double recovery_factor_after(double time) {
  return std::min(1.0, std::exp2(1 - time / recovery_patience));
}

/// Speed [m/s] that contact gives to what is so deep in a solid [m]: none where it is out, and that
/// little to what others have pushed in by a fraction of a millimetre that it does not leap.
inline double way_out_speed(double depth) {
  return std::min(recovery_speed, depth / recovery_time);
}

/// What is pressed on may sink in that far from where contact keeps it [m].
inline constexpr double may_sink = surface_offset / 2;

/// Where contact moves what is `distance` from a surface and should keep `kept` [m].
inline double raised(double distance, double kept) {
  return std::max(kept - may_sink, distance + overlap_share * (kept - distance));
}

/// How far from a surface what was `before` away from it, at the step's start, must end [m].
inline double required_distance(double before, double offset, double h) {
  return before < 0 ? std::min(offset, before + recovery_speed * h) : offset;
}

}  // namespace clothsim
