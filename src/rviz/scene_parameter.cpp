#include "scene_parameter.h"

#include <clothsim/LoadScene.h>
#include <ros/param.h>

#include "call_queue.h"

namespace clothsim_rviz {
namespace {

/// A plain scalar is what it looks like, as in YAML 1.1: roslaunch reads by that.
XmlRpc::XmlRpcValue to_scalar(const YAML::Node& node) {
  const std::string text = node.Scalar();
  if (node.Tag() == "!") return text;  // in quotes
  int whole = 0;
  if (YAML::convert<int>::decode(node, whole)) return whole;
  double number = 0;
  if (YAML::convert<double>::decode(node, number)) return number;
  bool flag = false;
  // y and n are texts there.
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

std::string load_scene(const std::string& node, const std::string& file) {
  const std::string parameter = node + "/scene";
  XmlRpc::XmlRpcValue scene, before;
  try {
    scene = to_xml_rpc(YAML::LoadFile(file));
  } catch (const YAML::Exception& error) {
    return file + ": " + error.what();
  }
  const bool had_one = ros::param::get(parameter, before);
  if (had_one) ros::param::del(parameter);  // else maps would be merged
  ros::param::set(parameter, scene);
  clothsim::LoadScene service;
  const std::string refusal = refusal_of(node + "/load_scene", service);
  if (refusal.empty()) return "";
  ros::param::del(parameter);
  if (had_one) ros::param::set(parameter, before);
  return refusal;
}

}  // namespace clothsim_rviz
