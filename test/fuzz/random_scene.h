#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clothsim/scene/scene.h"

namespace clothsim::testing {

/// Seconds that what moves in a random scene moves for, and that the scene goes on after that.
inline constexpr double driven_for = 1;
inline constexpr double still_for = 1;

/// How a collider or a pin moves from its start: there, or there and back.
struct Motion {
  Vector3 velocity{0, 0, 0};  // as it sets out [m/s]
  Vector3 turn{0, 0, 0};      // axis times rate [rad/s]
  double duration = driven_for;
  bool returns = false;

  bool moves() const { return velocity != Vector3::Zero() || turn != Vector3::Zero(); }

  /// Where it is at `time` [s] when it set out from `start` at 0.
  Pose at(double time, const Pose& start) const;
};

/// A scene with what moves in it.
struct RandomScene {
  Scene scene;
  std::vector<Motion> colliders;  // by collider
  std::vector<Motion> pins;       // by pin
  Vector3 velocity{0, 0, 0};      // of a cloth that is thrown [m/s]
  Vector3 spin{0, 0, 0};          // about its middle [rad/s]

  /// In a line, for people.
  std::string text() const;

  /// Fastest that anything is driven, at the radius of a collider's far end, or the wind [m/s].
  double max_drive_speed() const;

  /// May pins and colliders ask for longer springs than the strain limit grants?
  bool may_be_pulled() const;
};

/// Of a cloth with `most` points along a side at most. Equal seeds give equal scenes.
RandomScene random_scene(std::uint64_t seed, int most = 25);

/// The same scene with a fabric for a cloth, and in half of them wind.
RandomScene random_fabric_scene(std::uint64_t seed, int most = 25);

}  // namespace clothsim::testing
