#pragma once

#include "clothsim/model/cloth.h"
#include "clothsim/model/types.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// Largest displacement in a substep: of a collider, as a share of the shortest spring, and of one
/// end of a spring relative to the other, as a share of the spring's length. With 0.5 colliders
/// tear points off, or too much is left to the projection (see docs/experiments.md).
inline constexpr double motion_share = 0.25;

/// Number of substeps that a method needs for a frame of `dt` [s]: enough for h omega_max <
/// `stability_limit` (infinity: no bound) at the present stretch and, with a strain limit, enough
/// for the tension of the whole weight on the springs of one point; at least `min_steps`. It
/// depends on the arguments alone, so that a run continues the same way from any state. At most
/// max_substeps, whatever the material. `omega_max`: a known bound for springs of any stretch
/// [rad/s].
int count_substeps(const Cloth&, const Vector3& gravity, const Points& positions,
                   double stability_limit, double dt, int min_steps = 1, const Workers& = {},
                   double omega_max = infinity);

/// Number of substeps with which nothing that moves at `speed` [m/s] relative to the cloth passes
/// more than a quarter of the shortest spring in one of them. Otherwise a collider would stretch
/// springs too far before contact and the strain limit act. At most max_substeps.
int substeps_at_speed(const Cloth&, double speed, double dt);

/// Number of substeps with which the ends of no spring move by more than a quarter of its rest
/// length relative to each other in one of them. The strain limit cannot restore a spring that has
/// been stretched or turned too far before the limit acts. At least `min_steps`, at most
/// max_substeps.
int substeps_at_parting(const Cloth&, const Points& velocities, double dt, int min_steps = 1);

/// Number of substeps with h omega = 1, where omega is the frequency of a point whose springs carry
/// the whole weight. At most max_substeps.
int substeps_at_weight(const Cloth&, const Vector3& gravity, double dt);

/// Number of substeps for a cloth that may touch something, or whose strain limit yields. The
/// tension makes points oscillate at `frequency` [rad/s]; no more substeps are needed than for the
/// whole weight, or a `pull` [N] of holders and bodies if that is more, on the springs of one
/// point. At least `min_steps`, at most max_substeps. Half as many suffice if `is_smooth`: then no
/// edge, finger or other layer holds a point across its springs.
int substeps_at_tension(const Cloth&, const Vector3& gravity, double frequency, double dt,
                        int min_steps = 1, bool is_smooth = false, double pull = 0);

/// Number of substeps with which the inertia added for tension is at most 1.5 % of the cloth's
/// mass: with more inertia, passes over the strain limit do not converge. `mass_ratio`: that
/// inertia over the cloth's mass for a single step as long as the frame of `dt` [s]; it grows with
/// the square of the step. At most as many as for a taut chain, where the springs on either side of
/// every point carry the whole weight: where pins conflict with the limit, tension has no bound. At
/// least `min_steps`.
int substeps_at_mass_ratio(const Cloth&, const Vector3& gravity, double mass_ratio, double dt,
                           int min_steps = 1);

}  // namespace clothsim
