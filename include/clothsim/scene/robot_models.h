#pragma once

#include <string>
#include <vector>

#include "clothsim/scene/kinematics.h"
#include "clothsim/scene/scene_yaml.h"

namespace clothsim {

/// A robot of a scene, for programs that move its joints: the frame of each link is called PREFIX
/// and the link's name.
struct RobotModel {
  std::string name;
  std::string prefix;
  Pose pose;  // of its root
  Kinematics kinematics;
};

/// The robots in the YAML of a scene that read_scene() has accepted. Throws InvalidValue.
std::vector<RobotModel> read_robot_models(const YAML::Node& scene, const SceneSources&);

}  // namespace clothsim
