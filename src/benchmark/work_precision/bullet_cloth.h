#pragma once

#include "scenes.h"
#include "stepper.h"

namespace clothsim::work_precision {

/// Bullet's two kinds of soft body.
enum class BulletWorld {
  positions,  // btSoftRigidDynamicsWorld: links shortened by projection, as in Bullet's demos
  springs,    // btDeformableMultiBodyDynamicsWorld: springs in N/m, explicit, its default
};

/// A scene's cloth as a soft body of Bullet, with the same points, masses, links, pins, gravity and
/// drag, without contact. `iterations`: passes over the links in a substep (positions alone).
///
/// Links of the first kind have no stiffness in N/m. `matched`: each projection takes the share of
/// the elongation that a spring of the scene's stiffness would lose in the substep, spread over the
/// iterations; otherwise links have the largest stiffness, Bullet's default.
StepperMaker bullet(const Scene&, BulletWorld, int substeps, int iterations, bool matched);

}  // namespace clothsim::work_precision
