#pragma once

#include <vector>

#include "clothsim/scene/urdf.h"

namespace clothsim {

/// A link of a URDF and its collider.
struct LinkCollider {
  const Urdf::Link* link;
  ColliderSpec* collider;
};

/// Makes rigid bodies of the colliders of a URDF whose root is at `root` in the world. A link that
/// a movable joint connects to a link that stays becomes a body with that joint; links that are
/// fixed to it are parts of it, with their masses. A URDF without movable joints is one free body,
/// unless its root is called `world` or has no mass. All others stay. Throws InvalidValue for a
/// joint whose parent moves, a body without a mass, and limits that exclude 0.
void make_bodies(const Urdf&, const Pose& root, const std::vector<LinkCollider>&);

}  // namespace clothsim
