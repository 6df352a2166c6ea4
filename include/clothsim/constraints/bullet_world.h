#pragma once

#include <cstddef>
#include <vector>

#include "clothsim/constraints/body_collisions.h"

namespace clothsim {

/// The shapes of colliders in Bullet's collision detection. A mesh that is a body counts as its
/// convex hull. Planes have no shape.
class BulletWorld {
 public:
  virtual ~BulletWorld() = default;

  /// Has the shape flat faces alone? Not for planes.
  virtual bool is_polyhedral(std::size_t collider) const = 0;

  /// The places of a body and another collider, at these poses, with a gap of at most `reach` [m].
  virtual std::vector<BodyTouch> find(std::size_t body, std::size_t other, const Pose& of_body,
                                      const Pose& of_other, double reach) = 0;
};

}  // namespace clothsim

/// Makes a world, in the library clothsim_bullet.
extern "C" clothsim::BulletWorld* clothsim_bullet_world(
    const std::vector<clothsim::MovingCollider>& colliders, const std::vector<char>& is_body);
