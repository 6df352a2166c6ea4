#pragma once

#include <ros/node_handle.h>
#include <xmlrpcpp/XmlRpcValue.h>
#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <string>

#include "clothsim/scene/scene.h"

// A node's scene: the parameters ~scene, ~scene_file and ~scene_folder.

namespace clothsim_ros {

/// A scene with its sources.
struct GivenScene {
  clothsim::Scene scene;
  YAML::Node yaml;
  std::filesystem::path file;  // empty: it comes from ~scene
};

/// Reads the scene that a node starts with: the file of ~scene_file, with the values of ~scene laid
/// over it unless a node has put them there, else ~scene. Throws InvalidValue with keys relative to
/// the node.
GivenScene read_first_scene(const ros::NodeHandle& node);

/// Reads ~scene alone; paths in it begin at ~scene_folder. Throws InvalidValue likewise.
GivenScene read_scene_parameter(const ros::NodeHandle& node);

/// Reads a scene's file: package://PACKAGE/path, file:///path or an absolute path. Throws
/// InvalidValue likewise, with the key scene_file for what is no such file.
GivenScene read_scene_file(const std::string& file);

/// Has the parameters hold what runs: that of a file all over ~scene, beside its path.
void tell_scene(const ros::NodeHandle& node, const GivenScene&);

/// The same value as roslaunch makes it of a YAML file. Throws YAML::Exception for what is no
/// number, text, true, false, list or map.
XmlRpc::XmlRpcValue to_xml_rpc(const YAML::Node&);

}  // namespace clothsim_ros
