#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clothsim/scene/scene.h"

namespace clothsim::test {

/// Seconds with drive in a random scene, and seconds without it afterwards.
inline constexpr double driven_for = 1;
inline constexpr double still_for = 1;

/// Motion of a collider or a pin from its start: there, or there and back.
struct Motion {
  Vector3 velocity{0, 0, 0};  // at the start [m/s]
  Vector3 turn{0, 0, 0};      // axis times rate [rad/s]
  double duration = driven_for;
  bool returns = false;

  bool moves() const { return velocity != Vector3::Zero() || turn != Vector3::Zero(); }

  /// Pose at `time` [s] of a motion from `start` at 0.
  Pose at(double time, const Pose& start) const;
};

/// A scene and its motions.
struct RandomScene {
  Scene scene;
  std::vector<Motion> colliders;  // by collider
  std::vector<Motion> pins;       // by pin
  Vector3 velocity{0, 0, 0};      // of a thrown cloth [m/s]
  Vector3 spin{0, 0, 0};          // about its middle [rad/s]

  /// The scene in one line, for people.
  std::string text() const;

  /// Largest speed of the drive, at the far end of a collider, or of the wind [m/s].
  double max_drive_speed() const;

  /// Whether pins and colliders may stretch springs beyond the strain limit.
  bool may_be_pulled() const;
};

/// A scene of a cloth with at most `most` points along a side. Equal seeds give equal scenes.
RandomScene random_scene(std::uint64_t seed, int most = 25);

/// The same scene with a fabric for a cloth, and with wind in half of them.
RandomScene random_fabric_scene(std::uint64_t seed, int most = 25);

}  // namespace clothsim::test
