#include "scene_files.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>

#include "clothsim/ros/scene_parameter.h"

namespace clothsim_rviz {

std::string file_of(const XmlRpc::XmlRpcValue& scene, const std::vector<std::string>& files) {
  const auto holds_it = [&scene](const std::string& file) {
    try {
      return clothsim_ros::to_xml_rpc(YAML::LoadFile(file)) == scene;
    } catch (const YAML::Exception&) {  // for example, a file that is gone
      return false;
    }
  };
  const auto found = std::find_if(files.begin(), files.end(), holds_it);
  return found == files.end() ? "" : *found;
}

}  // namespace clothsim_rviz
