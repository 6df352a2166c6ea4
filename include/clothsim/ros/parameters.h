#pragma once

#include <ros/node_handle.h>
#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "clothsim/model/errors.h"
#include "clothsim/ros/diagnostic_limits.h"
#include "clothsim/scene/scene.h"
#include "clothsim/scene/yaml_values.h"
#include "clothsim/view/view_yaml.h"

namespace clothsim_ros {

/// The parameters that the node reads at its start.
struct NodeParameters {
  clothsim::Scene scene;
  YAML::Node scene_yaml;                     // the source of `scene`
  std::vector<clothsim::NamedView> cameras;  // ~camera, then those of ~cameras
  std::vector<std::string> image_folders;    // allowed for images, beside the package's
  DiagnosticLimits limits;
  double diagnostic_period = 1;  // [s]
  std::string world_frame = "map";
  double realtime_factor = 1;  // simulated seconds per second of ROS time; 0: unlimited
  double jump_speed = 15;      // speed of a frame beyond which it jumps [m/s]
  std::uint64_t save_limit = 1'000'000'000;  // memory for the states of ~save_state [bytes]
  bool paused = false;
  bool publish_clock = false;  // the node is the source of /clock
};

/// Calls `make`. Turns an InvalidValue into a std::runtime_error with the full name of the
/// parameter of `node`, whose keys are below `parent` (such as "scene/"; empty: below the node).
template <class Make>
auto with_full_name(const ros::NodeHandle& node, const std::string& parent, Make make) {
  try {
    return make();
  } catch (const clothsim::InvalidValue& error) {
    throw std::runtime_error(error.message(node.getNamespace() + "/" + parent, "/"));
  }
}

/// Reads the private parameters of `node`, and sets ~scene to the content of ~scene_file. Throws
/// std::runtime_error with the full name of the parameter, its value and the expected one.
NodeParameters read_parameters(const ros::NodeHandle& node);

/// The names of these parameters.
std::vector<std::string> parameter_names();

/// Reads ~cloth of the handles' node `node`: the clothsim node's namespace, in full. Throws as
/// read_parameters does.
std::string read_cloth_parameter(const ros::NodeHandle& node);

/// Reads parameter `key` of `node` if it is set. Throws the exceptions of `read`, inside that key.
void read_optional(const ros::NodeHandle& node, const std::string& key,
                   const clothsim::ReadValue& read);

/// The same value as YAML, so that parameters and files have one reader. A text counts as quoted.
/// Throws clothsim::InvalidValue for binary data and dates.
YAML::Node to_yaml(XmlRpc::XmlRpcValue value);

}  // namespace clothsim_ros
