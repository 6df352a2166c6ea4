#pragma once

#include <limits>

#include "clothsim/model/cloth.h"
#include "clothsim/model/types.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// Way of a collider in a substep, of the shortest spring, and of one end of a spring against the
/// other, of its length: half of it already tears points off or leaves too much to repairs (see
/// docs/experiments.md).
inline constexpr double way_share = 0.25;

/// Substeps that a method needs for a frame of `dt` [s]: enough to stay inside
/// h omega_max < `stability_limit` (infinity: none are needed for that) at the present stretch,
/// and, with a strain limit, enough for the tension of the whole weight on the springs of one
/// point; at least `min_steps`. A function of its arguments alone, so that a run goes on the same
/// way from any state. At most max_substeps, whatever the material. `omega_max`: what is known of
/// it for springs of any stretch [rad/s].
int count_substeps(const Cloth&, const Vector3& gravity, const Points& positions,
                   double stability_limit, double dt, int min_steps = 1, const Workers& = {},
                   double omega_max = std::numeric_limits<double>::infinity());

/// Substeps in which nothing that moves at `speed` [m/s] against the cloth passes more than a
/// quarter of its shortest spring at once: springs must not be torn over a collider before their
/// limit, and contact, can answer. At most max_substeps.
int substeps_at_speed(const Cloth&, double speed, double dt);

/// Substeps in which the ends of no spring move by more than a quarter of its rest length against
/// each other: a spring that has been torn open, or turned round, before its limit can answer, the
/// limit does not bring back. At least `min_steps`, at most max_substeps.
int substeps_at_parting(const Cloth&, const Points& velocities, double dt, int min_steps = 1);

/// Substeps that follow a tension of the whole weight on the springs of one point, h omega = 1. At
/// most max_substeps.
int substeps_at_weight(const Cloth&, const Vector3& gravity, double dt);

/// Substeps of a cloth that may touch something, or whose strain limit yields, under a tension that
/// lets points swing at `frequency` [rad/s], but not more than `pull` [N] on the springs of one
/// point asks for; at least `min_steps`. Half as many where all it touches `is_smooth`: edges,
/// fingers and other layers do not hold a point across its springs. At most max_substeps.
int substeps_at_tension(const Cloth&, double pull, double frequency, double dt, int min_steps = 1,
                        bool is_smooth = false);

/// Substeps in which the inertia that tension adds, `mass_ratio` of the cloth's mass in a step as
/// long as the frame of `dt` [s], is 1.5 % of it at most: it grows with the square of the step.
/// With more, passes over the strain limit do not get there. Not more than where the springs on
/// either side of every point carry the whole weight, as those of a taut chain do: where pins ask
/// for more than the limit grants, tension has no end. At least `min_steps`.
int substeps_at_mass_ratio(const Cloth&, const Vector3& gravity, double mass_ratio, double dt,
                           int min_steps = 1);

}  // namespace clothsim
