#pragma once

#include <xmlrpcpp/XmlRpcValue.h>
#include <yaml-cpp/yaml.h>

#include <string>

namespace clothsim_rviz {

/// The same value as roslaunch makes it of a YAML file. Throws YAML::Exception for what is no
/// number, text, true, false, list or map.
XmlRpc::XmlRpcValue to_xml_rpc(const YAML::Node&);

/// Has the node of that name load the scene of a file. Empty: it did; else why not, and its ~scene
/// is what it was.
std::string load_scene(const std::string& node, const std::string& file);

}  // namespace clothsim_rviz
