#pragma once

#include <utility>
#include <vector>

#include "clothsim/constraints/body_contacts.h"
#include "clothsim/constraints/rigid_bodies.h"

namespace clothsim::test {

inline constexpr double g = 9.8;  // [m/s^2]

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

/// Bodies and other colliders without a cloth.
struct World {
  explicit World(std::vector<ColliderSpec> of_scene) : specs(std::move(of_scene)), bodies(specs) {
    for (const ColliderSpec& spec : specs) colliders.emplace_back(spec);
    bodies.start(specs, colliders);
  }

  void step(double h, const Vector3& gravity = {0, 0, -g}) {
    bodies.begin_step(h, gravity, colliders);
    contacts.prepare(
        h, g, specs, colliders, [](double) { return std::vector<BodyTouch>(); }, bodies);
    for (int pass = 0; pass < 200 && contacts.solve_pass(bodies) > 1e-5; ++pass) {
    }
    bodies.end_step(contacts.pushes(bodies, {}), colliders);
  }

  Vector3 momentum() const {
    Vector3 sum(0, 0, 0);
    for (std::size_t k = 0; k < specs.size(); ++k) {
      if (specs[k].body) sum += specs[k].body->mass * bodies.motion(k).velocity;
    }
    return sum;
  }

  std::vector<ColliderSpec> specs;
  std::vector<MovingCollider> colliders;
  RigidBodies bodies;
  BodyContacts contacts;
};

}  // namespace clothsim::test
