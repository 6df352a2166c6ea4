#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "clothsim/shapes/moving_collider.h"

namespace clothsim {

/// A place where two colliders touch or come near each other.
struct BodyTouch {
  std::size_t a = 0;                    // of a rigid body
  std::size_t b = 0;                    // another collider
  Vector3 place{0, 0, 0};               // halfway between the surfaces, in the world [m]
  Vector3 normal{0, 0, 1};              // from b to a, unit
  double gap = 0;                       // between the surfaces, below 0 where they overlap [m]
  std::optional<double> friction = {};  // Coulomb's coefficient; none: by those of a and b
};

class BulletWorld;

/// Finds the places where rigid bodies come near each other and other colliders: by the signed
/// distances of corners and round parts where these touch, else with the collision detection of
/// Bullet, where a mesh that is a body counts as its convex hull. Results depend on the poses
/// alone.
class BodyCollisions {
 public:
  /// `colliders[k]` is a shape of a body where `is_body[k]`.
  BodyCollisions(const std::vector<MovingCollider>& colliders, const std::vector<char>& is_body);
  ~BodyCollisions();
  BodyCollisions(const BodyCollisions&) = delete;
  BodyCollisions& operator=(const BodyCollisions&) = delete;

  /// All places with a gap of at most `reach` [m] of pairs that `may_touch`.
  std::vector<BodyTouch> find(const std::vector<MovingCollider>&, double reach,
                              const std::function<bool(std::size_t, std::size_t)>& may_touch);

 private:
  std::unique_ptr<BulletWorld> world_;
  std::vector<std::pair<std::size_t, std::size_t>> pairs_;  // a body and another collider
};

}  // namespace clothsim
