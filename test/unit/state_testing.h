#pragma once

#include <string>

#include "verification/testing.h"

namespace clothsim::test {

inline constexpr double once = 0.35;  // [s] by then there is contact and the strain limit works
inline constexpr double more = 0.3;

/// A small cloth with pins, a ball, the ground and self contact.
inline Scene busy(const std::string& method) {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 10;
  scene.cloth.thickness = 0.02;
  scene.cloth.self_collision = SelfCollision::automatic;
  scene.cloth.material.ks = 300;
  scene.cloth.pinned = {{0, 0, ""}};
  ColliderSpec ball;
  ball.name = "ball";
  ball.pose.position = Vector3(0.5, 0.5, 0.75);
  ball.friction = 0.5;
  scene.colliders = {ball};
  scene.simulation.method = method;
  return scene;
}

inline void expect_same(const State& a, const State& b) {
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.velocities, b.velocities);
  EXPECT_EQ(a.time, b.time);
}

/// Springs and a pin alone: no point loses its history.
inline Scene swinging() {
  Scene scene = busy("bdf2");
  scene.colliders.clear();
  scene.cloth.self_collision = SelfCollision::off;
  scene.cloth.material.strain_limit.reset();
  return scene;
}

}  // namespace clothsim::test
