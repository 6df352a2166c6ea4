#pragma once

#include <yaml-cpp/yaml.h>

#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "clothsim/scene/scene.h"

namespace clothsim {

/// External data that a scene may refer to.
struct SceneSources {
  std::filesystem::path folder;  // for relative paths of files; empty: the working directory
  // The text of the parameter of that name, for robots; null: there are no parameters. Throws
  // InvalidValue, without a key, for a parameter that is missing or not text.
  std::function<std::string(const std::string&)> description = nullptr;
};

/// The only reader of scenes. Every key is optional except `cloth`; missing keys keep their
/// defaults. Throws InvalidValue for an unknown key, a wrong type, a non-finite number, a value out
/// of range, a file that cannot be used.
Scene read_scene(const YAML::Node& root, const SceneSources& = {});

/// Reads a map of switches, one for each spring family; missing keys keep their values. Throws
/// InvalidValue.
void read_springs(const YAML::Node&, std::array<bool, 3>& springs);

/// Reads the list `motions` of a scene with this cloth, without the files it names. Throws
/// InvalidValue.
std::vector<MotionEntry> read_motions(const YAML::Node&, const ClothSpec&);

/// Reads a rotation by roll, pitch and yaw [rad] about the fixed axes x, y and z in this order, as
/// in URDF. Throws InvalidValue.
Eigen::Quaterniond read_roll_pitch_yaw(const YAML::Node&);

/// Reads a map of `xyz` [m] and `rpy` [rad], each optional. Throws InvalidValue.
void read_pose(const YAML::Node&, Pose&);

/// Reads a map of live values: the keys of the material, thickness, self_collision and friction of
/// the cloth, those of `simulation` without its seed, collider_friction, a map by name, and cloths,
/// a map by name of several cloths: of the values that each may have of its own. Missing
/// keys keep their values, except that a new method resets its parameters. Throws InvalidValue for
/// keys and types; the values may then have changed in part.
void read_live_values(const YAML::Node&, LiveSpec&);

/// The same as a change for later.
ChangeValues read_change(const YAML::Node&);

/// Reads YAML text. Throws InvalidValue with `key` for text that is not YAML.
YAML::Node load_scene_text(const std::string& text, const std::string& key);

/// Reads a YAML file. Throws InvalidValue, also for a file that is missing or not YAML.
YAML::Node load_scene_file(const std::string& path);

/// Sets `path.to.key` in `root` from each "path.to.key=value", where value is YAML, one after the
/// other. Throws InvalidValue without a change.
void override_values(YAML::Node root, const std::vector<std::string>& assignments);

}  // namespace clothsim
