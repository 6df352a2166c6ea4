#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/dynamics/integrator.h"
#include "clothsim/model/checks.h"
#include "clothsim/model/cloth_spec.h"
#include "clothsim/scene/motion.h"
#include "clothsim/shapes/collider.h"

namespace clothsim {

/// Range of the substeps in a frame: with more a frame takes minutes.
inline constexpr Range substeps_range{1, 10'000, ""};
inline constexpr int max_substeps = static_cast<int>(substeps_range.max);

/// Range of the number of threads.
inline constexpr Range threads_range{1, 64, ""};

/// Most colliders: their ids in the mask image are a byte, from 2 on. Each of several cloths but
/// the first takes one of these ids.
inline constexpr std::size_t max_colliders = std::numeric_limits<std::uint8_t>::max() - 1;

/// Most bytes of a scene's file, or of a robot's: far above any real one.
inline constexpr std::size_t max_file_size = 16'000'000;

/// Longest part of a user's text [characters], or of a list, that a message repeats. Deeper paths
/// of keys could not be shown, and no value of a scene or a view lies as deep.
inline constexpr std::size_t longest_shown = 40;

/// Allowed rounding of numbers in text, relative to their size or in [m]; a shorter direction or
/// quaternion is invalid.
inline constexpr double written_rounding = 1e-6;

/// Range of positions [m] and velocities [m/s] of a cloth. Single precision can represent them, so
/// any valid state can be shown.
inline constexpr Range place_range{-1e12, 1e12, "m"};

/// Ranges of the mass, moments of inertia and velocities of a rigid body.
inline constexpr Range body_mass_range{1e-6, 1e6, "kg"};
inline constexpr Range body_damping_range{0, 1e3, "1/s"};
inline constexpr Range inertia_range{1e-15, 1e12, "kg m^2"};
inline constexpr Range velocity_range{-1e3, 1e3, "m/s"};
inline constexpr Range angular_velocity_range{-1e3, 1e3, "rad/s"};

struct SimulationSpec {
  Vector3 gravity{0, 0, -9.8};      // [m/s^2]
  std::optional<Vector3> wind;      // [m/s], the mean; empty: no air, except for gusts
  double gusts = 0;                 // [m/s] largest deviation of each component from the mean
  double frames_per_second = 90;    // [Hz]
  std::optional<int> substeps;      // per frame; empty: as many as the method needs
  double strain_tolerance = 0.004;  // allowed strain above cloth.strain_limit, of the rest length
  double tolerance = 1e-3;          // position error allowed for `auto`, of the cloth's size
  std::string method = "auto";      // or a name of method_names()
  MethodParameters method_parameters;  // of that method; none: its defaults
  std::uint64_t seed = 1;
  int threads = 1;  // the results do not depend on their number
};

/// The full definition of a simulation. Equal scenes give equal bits.
struct Scene {
  ClothSpec cloth;
  std::vector<ColliderSpec> colliders;
  SimulationSpec simulation;
  std::vector<std::string> left_out;  // unusable parts of robots, and why: for a log; not simulated
  std::vector<MotionEntry> motions;   // for a MotionPlayer; a simulator itself does not play them
};

/// Values of a scene that may change between two frames. With several cloths, `cloths` has those of
/// each, and `material`, `thickness` and `friction` those of the first; a value of these that
/// differs from the simulator's present one and from that of the first in `cloths` becomes that of
/// all cloths.
struct LiveSpec {
  struct OfCloth {
    std::string name;
    Material material;
    double friction;
    double thickness;
  };

  Material material;
  double thickness;  // this and the next two as in ClothSpec
  SelfCollision self_collision;
  double friction;
  std::map<std::string, double> collider_friction;  // by name of the collider
  SimulationSpec simulation;
  std::vector<OfCloth> cloths{};  // of several, by ClothSpec::parts; empty: one cloth
};

LiveSpec live_values(const Scene&);

/// Throws InvalidValue with the key {"method"} unless it is `auto` or a name of method_names().
void check_method(const std::string& method);

/// Throws InvalidValue with the key {"orientation"} unless it is a unit quaternion.
void check_orientation(const Eigen::Quaterniond&);

/// Throw InvalidValue for values beyond place_range, or not finite; for orientations that are not
/// unit quaternions.
void check_place(const Vector3&);
void check_place(const Pose&);

/// Throws InvalidValue, keys relative to the target, such as {"position", "0"}, for numbers that
/// are not finite, positions beyond 1e12 m, speeds beyond 1e6 m/s or rad/s and orientations that
/// are not unit quaternions.
void check(const FrameTarget&);

/// Throws InvalidValue with keys relative to the simulation, such as {"method"}.
void validate(const SimulationSpec&);

/// Throws InvalidValue with keys as of read_live_values(), such as {"collider_friction", "ball"}.
/// The material is checked by itself, without the size of the cloth.
void validate(const LiveSpec&);
/// Throws InvalidValue with keys relative to the collider, such as {"radius"}.
void validate(const ColliderSpec&);

/// Throws InvalidValue with the full key path, such as {"colliders", "0", "radius"}.
void validate(const Scene&);

}  // namespace clothsim
