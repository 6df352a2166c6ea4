#pragma once

#include <optional>

#include "clothsim/model/cloth.h"
#include "clothsim/model/types.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// What the strain limit puts into springs.
struct Tension {
  double frequency;  // [rad/s], see StrainLimit::tension_frequency()
  bool touches;      // a cloth that may touch something: contact wants shorter steps
};

/// Substeps that a method needs for a frame of `dt` [s]: enough to stay inside
/// h omega_max < `stability_limit` (infinity: none are needed for that) at the present stretch,
/// and, with a strain limit, to follow the tension that the limit puts into the springs: that of
/// substeps_under_tension(), without a `tension` that of the whole weight. A function of its
/// arguments alone, so that a run goes on the same way from any state. At most max_substeps,
/// whatever the material.
int count_substeps(const Cloth&, const Vector3& gravity, const Points& positions,
                   double stability_limit, double dt, std::optional<Tension> tension = {},
                   const Workers& = {});

/// Frequency [rad/s] across the springs of a point that carry the whole cloth's weight, as the
/// strain limit can make them near a pin: omega^2 = T / (m l). Without a strain limit 0.
double weight_frequency(const Cloth&, const Vector3& gravity);

/// Substeps of `dt` [s] in which the strain limit can follow a tension: not more than the whole
/// `weight` [rad/s] on the springs of one point would ask for, and not less than nearly half of
/// that, since tension can come within a substep. If the cloth may touch something, which may carry
/// it by fewer points than pins would: from two thirds of that number to twice it.
int substeps_under_tension(double weight, const Tension&, double dt);

/// Substeps in which nothing that moves at `speed` [m/s] against the cloth passes more than a
/// quarter of its shortest spring at once: springs must not be torn over a collider before their
/// limit, and contact, can answer. At most max_substeps.
int substeps_at_speed(const Cloth&, double speed, double dt);

/// Substeps in which the ends of no spring move by more than a quarter of its rest length against
/// each other: a spring that has been torn open, or turned round, before its limit can answer, the
/// limit does not bring back. At most max_substeps.
int substeps_at_parting(const Cloth&, const Points& velocities, double dt);

/// Do two points that are held ask for all that the strain limit grants, within 1 %, or more? Then
/// it pulls without end, and springs part the faster the shorter the steps. Needs a strain limit.
bool are_pulled_taut(const Cloth&, const Points& positions);

}  // namespace clothsim
