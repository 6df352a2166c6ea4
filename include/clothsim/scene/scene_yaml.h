#pragma once

#include <yaml-cpp/yaml.h>

#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "clothsim/scene/scene.h"

namespace clothsim {

/// What a scene refers to.
struct SceneSources {
  std::filesystem::path folder;  // that paths of files begin at; empty: where the program runs
  // The text of the parameter of that name, for robots; none: there are no parameters. Throws
  // InvalidValue, without a key, for one that is not there or no text.
  std::function<std::string(const std::string&)> description = nullptr;
};

/// The only reader of scenes. Every key is optional but `cloth`; what is left out keeps its
/// default. Throws InvalidValue for an unknown key, a wrong type, a non-finite number, a value out
/// of range, a file that cannot be used.
Scene read_scene(const YAML::Node& root, const SceneSources& = {});

/// Reads a map of switches, one for each spring family; what is left out keeps its value. Throws
/// InvalidValue.
void read_springs(const YAML::Node&, std::array<bool, 3>& springs);

/// Reads the list `motions` of a scene, but not the files it names. Throws InvalidValue.
std::vector<MotionEntry> read_motions(const YAML::Node&);

/// Reads a rotation by roll, pitch and yaw [rad] about the fixed axes x, y and z in this order, as
/// in URDF. Throws InvalidValue.
Eigen::Quaterniond read_roll_pitch_yaw(const YAML::Node&);

/// Reads a map of `xyz` [m] and `rpy` [rad], each of which may be left out. Throws InvalidValue.
void read_pose(const YAML::Node&, Pose&);

/// Reads a map of what may change while a cloth moves: the keys of the material, thickness,
/// self_collision and friction of the cloth, those of `simulation` but its seed, and
/// collider_friction, a map by name. What is left out keeps its value, but parameters go with their
/// method. Throws InvalidValue for keys and types; the values may then have changed in part.
void read_live_values(const YAML::Node&, LiveSpec&);

/// The same as a change for later.
ChangeValues read_change(const YAML::Node&);

/// Reads YAML text. Throws InvalidValue with `key` for what is not YAML.
YAML::Node load_scene_text(const std::string& text, const std::string& key);

/// Reads a YAML file. Throws InvalidValue, also for a file that is missing or not YAML.
YAML::Node load_scene_file(const std::string& path);

/// Sets `path.to.key` in `root` from each "path.to.key=value", where value is YAML, one after the
/// other. Throws InvalidValue and changes nothing.
void override_values(YAML::Node root, const std::vector<std::string>& assignments);

}  // namespace clothsim
