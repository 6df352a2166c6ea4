#pragma once

#include <limits>

#include "clothsim/model/cloth.h"
#include "clothsim/model/types.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// Largest displacement of a collider in a substep, of the shortest spring, and of one end of a
/// spring relative to the other, of its length: half of it already tears points off or leaves too
/// much to projection (see docs/experiments.md).
inline constexpr double way_share = 0.25;

/// Substeps that a method needs for a frame of `dt` [s]: enough for h omega_max < `stability_limit`
/// (infinity: no bound) at the present stretch, and, with a strain limit, enough for the tension of
/// the whole weight on the springs of one point; at least `min_steps`. A function of its arguments
/// alone, so that a run continues the same way from any state. At most max_substeps, whatever the
/// material. `omega_max`: a known bound for springs of any stretch [rad/s].
int count_substeps(const Cloth&, const Vector3& gravity, const Points& positions,
                   double stability_limit, double dt, int min_steps = 1, const Workers& = {},
                   double omega_max = std::numeric_limits<double>::infinity());

/// Substeps in which nothing that moves at `speed` [m/s] relative to the cloth passes more than a
/// quarter of its shortest spring at once: otherwise springs would tear over a collider before
/// their limit, and contact, can act. At most max_substeps.
int substeps_at_speed(const Cloth&, double speed, double dt);

/// Substeps in which the ends of no spring move by more than a quarter of its rest length relative
/// to each other: the limit cannot restore a spring that has been torn open, or turned round,
/// before it can act. At least `min_steps`, at most max_substeps.
int substeps_at_parting(const Cloth&, const Points& velocities, double dt, int min_steps = 1);

/// Substeps that follow a tension of the whole weight on the springs of one point, h omega = 1. At
/// most max_substeps.
int substeps_at_weight(const Cloth&, const Vector3& gravity, double dt);

/// Substeps of a cloth that may touch something, or whose strain limit yields, under a tension that
/// makes points oscillate at `frequency` [rad/s], but not more than for the whole weight, or a
/// holder's `strength` [N], on the springs of one point; at least `min_steps`. Half as many where
/// all contacts are `is_smooth`: edges, fingers and other layers do not hold a point across its
/// springs. At most max_substeps.
int substeps_at_tension(const Cloth&, const Vector3& gravity, double frequency, double dt,
                        int min_steps = 1, bool is_smooth = false, double strength = 0);

/// Substeps in which the inertia added for tension is 1.5 % of the cloth's mass at most;
/// `mass_ratio`: that of a single step as long as the frame of `dt` [s]. It grows with the square
/// of the step, and with more, passes over the strain limit do not converge. Not more than where
/// the springs on either side of every point carry the whole weight, as those of a taut chain do:
/// where pins conflict with the limit, tension has no bound. At least `min_steps`.
int substeps_at_mass_ratio(const Cloth&, const Vector3& gravity, double mass_ratio, double dt,
                           int min_steps = 1);

}  // namespace clothsim
