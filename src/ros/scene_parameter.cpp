#include "clothsim/ros/scene_parameter.h"

#include <ros/names.h>
#include <ros/param.h>

#include <system_error>

#include "clothsim/model/checks.h"
#include "clothsim/model/errors.h"
#include "clothsim/model/resource.h"
#include "clothsim/ros/parameters.h"
#include "clothsim/scene/scene_yaml.h"
#include "clothsim/scene/yaml_values.h"

namespace clothsim_ros {
namespace {

namespace fs = std::filesystem;
using clothsim::InvalidValue;

// The node's parameters.
constexpr const char* scene_key = "scene";
constexpr const char* file_key = "scene_file";
constexpr const char* folder_key = "scene_folder";

/// Longest part of a file's name that a message repeats.
constexpr std::size_t longest_shown_name = 200;

/// The text of a robot's description; a relative name is below the node's namespace.
std::string read_description(const std::string& name) {
  XmlRpc::XmlRpcValue value;
  try {
    if (!ros::param::get(name, value)) {
      throw InvalidValue({}, clothsim::shortened(name, 100) + ", which is not set",
                         "a parameter with a URDF");
    }
  } catch (const ros::InvalidNameException& error) {
    throw InvalidValue({}, clothsim::shortened(error.what(), 200), "the name of a parameter");
  }
  return clothsim::read_text(to_yaml(value));
}

/// The parameter's text; empty where it is not set.
std::string text_parameter(const ros::NodeHandle& node, const std::string& key) {
  std::string text;
  read_optional(node, key, [&](const YAML::Node& given) { text = clothsim::read_text(given); });
  return text;
}

clothsim::Scene read(const YAML::Node& yaml, const fs::path& folder) {
  clothsim::Scene scene;
  clothsim::inside(scene_key, [&] {
    scene = clothsim::read_scene(yaml, {folder, read_description});
  });
  return scene;
}

/// Refuses other files before they are opened, as messages repeat the beginning of a file.
void check_ending(const fs::path& path, const std::string& name) {
  if (path.is_absolute() && (path.extension() == ".yaml" || path.extension() == ".yml")) return;
  throw InvalidValue(
      {}, '"' + clothsim::shortened(name, longest_shown_name) + '"',
      "package://PACKAGE/path, file:///path or an absolute path, which ends in .yaml");
}

/// The file of that name, and its content.
GivenScene open_file(const std::string& name) {
  GivenScene given;
  clothsim::inside(file_key, [&] {
    given.file = clothsim::find_resource(name, "");
    check_ending(given.file, name);
    std::error_code error;
    if (!fs::is_regular_file(given.file, error)) {
      throw InvalidValue(
          {}, '"' + clothsim::shortened(name, longest_shown_name) + "\", which is not there",
          "a scene's file");
    }
    given.yaml = clothsim::load_scene_file(given.file);
  });
  return given;
}

/// `under` with the values of `over` in place of its own, map by map.
YAML::Node laid_over(const YAML::Node& over, const YAML::Node& under) {
  if (!over.IsMap() || !under.IsMap()) return over;
  YAML::Node both = YAML::Clone(under);
  for (const auto& item : over) {
    const std::string key = item.first.Scalar();
    both[key] = under[key].IsDefined() ? laid_over(item.second, under[key]) : item.second;
  }
  return both;
}

/// A plain scalar has the type that YAML 1.1 gives it, as in roslaunch.
XmlRpc::XmlRpcValue to_scalar(const YAML::Node& node) {
  const std::string text = node.Scalar();
  if (node.Tag() == "!") return text;  // in quotes
  int whole = 0;
  if (YAML::convert<int>::decode(node, whole)) return whole;
  double number = 0;
  if (YAML::convert<double>::decode(node, number)) return number;
  bool flag = false;
  // y and n are texts in roslaunch.
  if (text.size() > 1 && YAML::convert<bool>::decode(node, flag)) return flag;
  return text;
}

XmlRpc::XmlRpcValue to_list(const YAML::Node& node) {
  XmlRpc::XmlRpcValue list;
  list.setSize(static_cast<int>(node.size()));
  for (std::size_t i = 0; i < node.size(); ++i) list[static_cast<int>(i)] = to_xml_rpc(node[i]);
  return list;
}

XmlRpc::XmlRpcValue to_map(const YAML::Node& node) {
  XmlRpc::XmlRpcValue map;
  map.begin();  // makes it a map, also where it is empty
  for (const auto& item : node) map[item.first.as<std::string>()] = to_xml_rpc(item.second);
  return map;
}

}  // namespace

GivenScene read_first_scene(const ros::NodeHandle& node) {
  const std::string name = text_parameter(node, file_key);
  if (name.empty()) return read_scene_parameter(node);
  GivenScene given = open_file(name);
  // Only a node sets the folder: ~scene then comes from an earlier node.
  if (!node.hasParam(folder_key)) {
    read_optional(node, scene_key,
                  [&](const YAML::Node& over) { given.yaml = laid_over(over, given.yaml); });
  }
  given.scene = read(given.yaml, given.file.parent_path());
  return given;
}

GivenScene read_scene_parameter(const ros::NodeHandle& node) {
  GivenScene given;
  bool is_set = false;
  read_optional(node, scene_key, [&](const YAML::Node& yaml) {
    given.yaml = yaml;
    is_set = true;
  });
  if (!is_set) {
    throw InvalidValue({scene_key}, "nothing",
                       "a scene, such as config/scenes/*.yaml, or its file in ~scene_file");
  }
  if (given.yaml.IsMap() && !given.yaml["cloth"].IsDefined() && !given.yaml["cloths"].IsDefined()) {
    throw InvalidValue({scene_key, "cloth"}, "nothing",
                       "a map, which rosparam drops where it is empty, unlike ~scene_file");
  }
  given.scene = read(given.yaml, text_parameter(node, folder_key));
  return given;
}

GivenScene read_scene_file(const std::string& file) {
  GivenScene given = open_file(file);
  given.scene = read(given.yaml, given.file.parent_path());
  return given;
}

void tell_scene(const ros::NodeHandle& node, const GivenScene& given) {
  if (given.file.empty()) {
    node.deleteParam(file_key);
    return;
  }
  node.deleteParam(scene_key);  // as maps would be merged
  node.setParam(scene_key, to_xml_rpc(given.yaml));
  node.setParam(folder_key, given.file.parent_path().string());
  node.setParam(file_key, given.file.string());
}

XmlRpc::XmlRpcValue to_xml_rpc(const YAML::Node& node) {
  switch (node.Type()) {
    case YAML::NodeType::Scalar:
      return to_scalar(node);
    case YAML::NodeType::Sequence:
      return to_list(node);
    case YAML::NodeType::Map:
      return to_map(node);
    default:
      throw YAML::RepresentationException(node.Mark(), "a value is missing");
  }
}

}  // namespace clothsim_ros
