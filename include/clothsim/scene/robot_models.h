#pragma once

#include <string>
#include <vector>

#include "clothsim/scene/kinematics.h"
#include "clothsim/scene/scene_yaml.h"

namespace clothsim {

/// A robot of a scene as one who moves its joints has it: the frame of each link is called PREFIX
/// and the link's name.
struct RobotModel {
  std::string name;
  std::string prefix;
  Pose pose;  // of its root
  Kinematics kinematics;
};

/// Those of a scene's YAML that read_scene() has taken. Throws InvalidValue.
std::vector<RobotModel> read_robot_models(const YAML::Node& scene, const SceneSources&);

}  // namespace clothsim
