#pragma once

#include "clothsim/shapes/collider.h"

namespace clothsim::testing {

/// A rigid body at a place [m], of a mass [kg].
inline ColliderSpec body(const Shape& shape, const Vector3& at, double mass = 1,
                         double friction = 0.4) {
  ColliderSpec spec;
  spec.name = "body";
  spec.shape = shape;
  spec.pose.position = at;
  spec.friction = friction;
  spec.body.emplace();
  spec.body->mass = mass;
  return spec;
}

}  // namespace clothsim::testing
