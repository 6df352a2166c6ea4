#pragma once

#include <Eigen/Geometry>

#include "clothsim/scene/scene.h"

namespace clothsim_rviz {

/// A box of RViz's fixed frame [m], with the world at `in_fixed`, around a scene's motion: the
/// cloth at its start, and as it hangs from its pins or over its colliders; the ground below it;
/// its colliders, up to the cloth's size away from it.
Eigen::AlignedBox3d stage_of(const clothsim::Scene&, const clothsim::Pose& in_fixed = {});

/// A camera's lens: tangents of half its angles of view.
struct Lens {
  double across;
  double up;
};

/// Distance [m] from the box's middle at which a camera sees all of it, with a margin. The camera
/// looks at the middle against `out`, the unit vector to the camera, and has z upright.
double viewing_distance(const Eigen::AlignedBox3d&, const clothsim::Vector3& out, const Lens&);

}  // namespace clothsim_rviz
