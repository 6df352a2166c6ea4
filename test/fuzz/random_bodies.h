#pragma once

#include <cstdint>
#include <string>

#include "clothsim/scene/scene.h"

namespace clothsim::test {

/// Place of the cloth: held by its corners, on a floor or a table, or hung by an edge.
enum class Setting { trampoline, laid, hung };

/// A scene of rigid bodies and a cloth, and the motion of the frame that holds one of the bodies.
struct BodyScene {
  Scene scene;
  Setting setting = Setting::trampoline;
  int held = -1;                             // collider; none
  Vector3 velocity{0, 0, 0}, turn{0, 0, 0};  // [m/s], axis times rate [rad/s]
  std::string text;                          // the scene in one line, for people
};

/// A scene of bodies on, over and under a cloth. Equal seeds give equal scenes.
BodyScene random_body_scene(std::uint64_t seed);

}  // namespace clothsim::test
