#pragma once

#include <utility>
#include <vector>

#include "clothsim/scene/scene.h"

namespace clothsim::test {

/// `turn`: axis times angle [rad].
inline Pose pose_at(const Vector3& position, const Vector3& turn = Vector3::Zero()) {
  const double angle = turn.norm();
  Pose pose{position, Eigen::Quaterniond::Identity()};
  if (angle > 0) pose.orientation = Eigen::AngleAxisd(angle, turn / angle);
  return pose;
}

/// A cloth of `side` x `side` points.
inline Scene with_colliders(std::vector<ColliderSpec> colliders, int side = 25) {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = side;
  scene.colliders = std::move(colliders);
  return scene;
}

/// The same, held by two corners.
inline Scene hanging_with(std::vector<ColliderSpec> colliders, int side = 25) {
  Scene scene = with_colliders(std::move(colliders), side);
  scene.cloth.pinned = {{0, 0, ""}, {side - 1, 0, ""}};
  return scene;
}

}  // namespace clothsim::test
