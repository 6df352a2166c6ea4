#pragma once

#include <Eigen/Geometry>

#include "clothsim/scene/scene.h"

namespace clothsim_rviz {

/// A box of RViz's fixed frame [m], with the world at `in_fixed`, that holds what happens in a
/// scene: the cloth as it starts, and as it hangs from its pins or over its colliders; the ground
/// below it; its colliders, no farther from the cloth than that is large.
Eigen::AlignedBox3d stage_of(const clothsim::Scene&, const clothsim::Pose& in_fixed = {});

/// A camera's lens: tangents of half its angles of view.
struct Lens {
  double across;
  double up;
};

/// How far from the box's middle a camera sees all of it, with a margin, that looks at the middle
/// against `out`, the unit vector to the camera, and has z upright [m].
double viewing_distance(const Eigen::AlignedBox3d&, const clothsim::Vector3& out, const Lens&);

}  // namespace clothsim_rviz
