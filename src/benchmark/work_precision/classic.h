#pragma once

#include "scenes.h"
#include "stepper.h"

namespace clothsim::work_precision {

/// The classic cloth simulator (Provot 1995), in plain code: one spring at a time, symplectic
/// Euler, a loss of velocity per step that equals the scene's drag, and then `passes` over all
/// springs, each of which moves the ends of a spring over its limit together, a free end the whole
/// way where the other is pinned. Velocities do not change; or they `follow` the moved positions,
/// as with Verlet's method on positions alone.
StepperMaker classic(const Scene& scene, int substeps, int passes, bool follow = false);

}  // namespace clothsim::work_precision
