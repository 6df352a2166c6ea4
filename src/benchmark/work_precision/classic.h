#pragma once

#include "scenes.h"
#include "stepper.h"

namespace clothsim::work_precision {

/// The classic cloth simulator (Provot 1995), written plainly: one spring at a time, symplectic
/// Euler, the share of the velocity lost per step that gives the scene's drag, and then `passes`
/// over all springs, each of which moves the ends of a spring over its limit together, a free end
/// the whole way where the other is pinned. Velocities stay as they were; or they `follow` the
/// moved positions, as with Verlet's method on positions alone.
StepperMaker classic(const Scene& scene, int substeps, int passes, bool follow = false);

}  // namespace clothsim::work_precision
