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
  std::filesystem::path file;  // empty: from ~scene
};

/// Reads the node's first scene: the file of ~scene_file, with values replaced by those of ~scene
/// unless ~scene comes from an earlier node, else ~scene. Throws InvalidValue with keys relative to
/// the node.
GivenScene read_first_scene(const ros::NodeHandle& node);

/// Reads ~scene alone; its paths are relative to ~scene_folder. Throws InvalidValue with keys
/// relative to the node.
GivenScene read_scene_parameter(const ros::NodeHandle& node);

/// Reads a scene's file: package://PACKAGE/path, file:///path or an absolute path. Throws
/// InvalidValue with keys relative to the node, and with the key scene_file for an unusable file.
GivenScene read_scene_file(const std::string& file);

/// Sets the parameters to the running scene: ~scene to the content of its file, beside the file's
/// path.
void tell_scene(const ros::NodeHandle& node, const GivenScene&);

/// The value that roslaunch makes of the same YAML. Throws YAML::Exception for nodes other than
/// numbers, texts, true, false, lists and maps.
XmlRpc::XmlRpcValue to_xml_rpc(const YAML::Node&);

}  // namespace clothsim_ros
