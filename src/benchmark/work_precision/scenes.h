#pragma once

#include <optional>
#include <string>
#include <vector>

#include "clothsim/scene/scene.h"

namespace clothsim::work_precision {

/// The part of a trajectory that is compared.
enum class Compared { all_frames, rest_shape };

/// A scene for the comparison of methods.
struct Trial {
  std::string name;
  Scene scene;
  int frames;
  Compared compared;
  bool smooth;              // neither contact nor strain limit: the reference must show its order
  int max_newton_substeps;  // finest step of the methods that take milliseconds a step
  bool split;               // solver error and scheme error are separated
  /// Drag of the reference, where it differs from the scene's [1/s]: a shape at rest does not
  /// depend on it.
  std::optional<double> reference_damping{};
  double charted_error = 1e-4;  // smallest error that the reference must resolve at its horizon
};

/// A shipped scene with `side` x `side` points, its pins kept at the corners.
Scene shipped_scene(const std::string& name, int side);

/// A cloth hung from two corners, without strain limit.
Scene corner_drop(int side);

/// A cloth dropped on the sphere, without strain limit.
Scene sphere_drop(int side);

/// self_collision, its thickness reduced with the distance of the points, its surface kept from
/// crossing.
Scene fold(int side);

/// The scenes of the chart of methods. Quick: the first alone, small and short.
std::vector<Trial> trials(bool quick);

}  // namespace clothsim::work_precision
