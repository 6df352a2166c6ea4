#include "clothsim/ros/parameters.h"

#include <ros/master.h>
#include <ros/names.h>
#include <ros/param.h>
#include <ros/this_node.h>

#include "clothsim/model/checks.h"
#include "clothsim/render/egl_context.h"
#include "clothsim/ros/scene_parameter.h"
#include "clothsim/scene/yaml_values.h"
#include "clothsim/view/view_yaml.h"

namespace clothsim_ros {
namespace {

using clothsim::InvalidValue;

/// Range of the real-time factor; `paused` or 0 replace factors outside.
constexpr double min_factor = 0.001;
constexpr double max_factor = 1000;

constexpr clothsim::Range jump_speed_range{0, 1e9, "m/s"};
constexpr clothsim::Range diagnostic_period_range{0.1, 3600, "s"};

YAML::Node to_yaml_list(XmlRpc::XmlRpcValue& value) {
  YAML::Node list(YAML::NodeType::Sequence);
  for (int i = 0; i < value.size(); ++i) {
    clothsim::inside(std::to_string(i), [&] { list.push_back(to_yaml(value[i])); });
  }
  return list;
}

YAML::Node to_yaml_map(XmlRpc::XmlRpcValue& value) {
  YAML::Node map(YAML::NodeType::Map);
  for (auto& [key, item] : value) {
    // Not map[key], which compares all keys: they are distinct here.
    clothsim::inside(key,
                     [&, &name = key, &child = item] { map.force_insert(name, to_yaml(child)); });
  }
  return map;
}

/// Another node that publishes a topic according to the master; empty: there is none.
std::string other_publisher(const std::string& topic) {
  XmlRpc::XmlRpcValue request;
  XmlRpc::XmlRpcValue answer;
  XmlRpc::XmlRpcValue state;  // publishers, subscribers, services: each [[topic, [node, ...]], ...]
  request[0] = ros::this_node::getName();
  if (!ros::master::execute("getSystemState", request, answer, state, true)) return "";
  XmlRpc::XmlRpcValue& publishers = state[0];
  for (int i = 0; i < publishers.size(); ++i) {
    if (static_cast<std::string>(publishers[i][0]) != topic) continue;
    XmlRpc::XmlRpcValue& nodes = publishers[i][1];
    for (int j = 0; j < nodes.size(); ++j) {
      const std::string node = nodes[j];
      if (node != ros::this_node::getName()) return node;
    }
  }
  return "";
}

/// Checks that the source of /clock uses /clock, and is the only source.
void check_clock() {
  if (!ros::param::param("/use_sim_time", false)) {
    throw InvalidValue({"publish_clock"}, "true",
                       "/use_sim_time to be true too: without it no node listens to the clock, "
                       "and this node's time would not be that of the others");
  }
  const std::string other = other_publisher("/clock");
  if (!other.empty()) {
    throw InvalidValue({"publish_clock"}, "true",
                       "no other source of time, but " + other +
                           " publishes /clock ('rosnode cleanup' forgets nodes that are gone)");
  }
}

bool holds_image_topic(const YAML::Node& node) {
  return node.IsMap() && node.size() == 1 && node["image_raw"].IsDefined();
}

/// image_transport keeps its parameters beside the view's, below the names of the image topics.
YAML::Node without_topics(YAML::Node camera) {
  if (!camera.IsMap()) return camera;
  for (const char* topic : {"color", "depth", "mask"}) {
    if (holds_image_topic(camera[topic])) camera.remove(topic);
  }
  return camera;
}

/// Reads one of ~cameras. Its topics are below `camera_NAME`: no other name of the node begins so.
clothsim::NamedView read_other_camera(const YAML::Node& given,
                                      const std::vector<clothsim::NamedView>& others) {
  clothsim::NamedView camera = clothsim::read_camera(given, others.front().view);
  const std::string name = camera.name;
  camera.name = "camera_" + name;
  std::string mistake;
  if (name.empty() || name.find('/') != std::string::npos ||
      !ros::names::validate(camera.name, mistake)) {
    throw InvalidValue({"name"}, '"' + name + '"', "letters, digits and underscores, such as left");
  }
  for (const clothsim::NamedView& other : others) {
    if (other.name == camera.name) {
      throw InvalidValue({"name"}, '"' + name + '"', "a name that no camera before it has");
    }
  }
  return camera;
}

void read_cameras(const ros::NodeHandle& node, NodeParameters& parameters) {
  YAML::Node camera(YAML::NodeType::Map);
  read_optional(node, "camera", [&](const YAML::Node& given) { camera = given; });
  clothsim::inside("camera", [&] {
    const clothsim::View view = clothsim::read_view(without_topics(camera));
    clothsim::check_names(view, parameters.scene);
    if (view.egl_device) clothsim::check_egl_device(*view.egl_device);
    parameters.cameras = {{"camera", view}};
  });
  read_optional(node, "cameras", [&](const YAML::Node& given) {
    clothsim::read_list(given, [&](const YAML::Node& item) {
      const clothsim::NamedView other = read_other_camera(item, parameters.cameras);
      if (other.view.egl_device) {
        clothsim::inside("egl_device", [&] { clothsim::check_egl_device(*other.view.egl_device); });
      }
      parameters.cameras.push_back(other);
    });
  });
}

NodeParameters read(const ros::NodeHandle& node) {
  NodeParameters parameters;
  const GivenScene given_scene = read_first_scene(node);
  parameters.scene = given_scene.scene;
  parameters.scene_yaml = given_scene.yaml;

  read_cameras(node, parameters);

  read_optional(node, "image_folders", [&](const YAML::Node& given) {
    clothsim::read_list(given, [&](const YAML::Node& item) {
      parameters.image_folders.push_back(clothsim::read_text(item));
    });
  });
  if (!given_scene.file.empty()) {
    parameters.image_folders.push_back(given_scene.file.parent_path().string());
  }
  read_optional(node, "diagnostics", [&](const YAML::Node& given) {
    parameters.limits = read_diagnostic_limits(given);
  });
  read_optional(node, "diagnostic_period", clothsim::into(parameters.diagnostic_period));
  read_optional(node, "world_frame", clothsim::into(parameters.world_frame));
  read_optional(node, "realtime_factor", clothsim::into(parameters.realtime_factor));
  read_optional(node, "jump_speed", clothsim::into(parameters.jump_speed));
  read_optional(node, "save_limit", clothsim::into(parameters.save_limit));
  read_optional(node, "paused", clothsim::into(parameters.paused));
  read_optional(node, "publish_clock", clothsim::into(parameters.publish_clock));

  if (parameters.world_frame.front() == '/') {
    throw InvalidValue({"world_frame"}, '"' + parameters.world_frame + '"',
                       "a tf frame without a leading slash");
  }
  const double factor = parameters.realtime_factor;
  if (factor != 0 && !(factor >= min_factor && factor <= max_factor)) {
    throw InvalidValue({"realtime_factor"}, clothsim::to_text(factor),
                       "0 or a number from " + clothsim::to_text(min_factor) + " to " +
                           clothsim::to_text(max_factor));
  }
  clothsim::check_range("diagnostic_period", parameters.diagnostic_period, diagnostic_period_range);
  clothsim::check_range("jump_speed", parameters.jump_speed, jump_speed_range);
  if (parameters.publish_clock) check_clock();
  if (!given_scene.file.empty()) tell_scene(node, given_scene);
  return parameters;
}

}  // namespace

void read_optional(const ros::NodeHandle& node, const std::string& key,
                   const clothsim::ReadValue& read) {
  XmlRpc::XmlRpcValue value;
  if (!node.getParam(key, value)) return;
  clothsim::inside(key, [&] { read(to_yaml(value)); });
}

YAML::Node to_yaml(XmlRpc::XmlRpcValue value) {
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeBoolean:
      return YAML::Node(static_cast<bool>(value));
    case XmlRpc::XmlRpcValue::TypeInt:
      return YAML::Node(static_cast<int>(value));
    case XmlRpc::XmlRpcValue::TypeDouble:
      return clothsim::number_node(value);
    case XmlRpc::XmlRpcValue::TypeString:
      return clothsim::text_node(value);
    case XmlRpc::XmlRpcValue::TypeArray:
      return to_yaml_list(value);
    case XmlRpc::XmlRpcValue::TypeStruct:
      return to_yaml_map(value);
    case XmlRpc::XmlRpcValue::TypeInvalid:
      return YAML::Node();
    default:
      throw InvalidValue({}, "binary data or a date",
                         "a number, a text, true, false, a list or a map");
  }
}

NodeParameters read_parameters(const ros::NodeHandle& node) {
  return with_full_name(node, "", [&] { return read(node); });
}

std::vector<std::string> parameter_names() {
  return {"scene",       "scene_file",      "scene_folder", "camera",
          "cameras",     "image_folders",   "diagnostics",  "diagnostic_period",
          "world_frame", "realtime_factor", "jump_speed",   "save_limit",
          "paused",      "publish_clock"};
}

std::string read_cloth_parameter(const ros::NodeHandle& node) {
  std::string name = "clothsim";
  with_full_name(node, "", [&] {
    read_optional(node, "cloth", clothsim::into(name));
    std::string mistake;
    if (!ros::names::validate(name, mistake)) {
      throw InvalidValue({"cloth"}, '"' + name + '"',
                         "the name of a clothsim node, such as clothsim or /left/clothsim");
    }
  });
  return ros::names::resolve(name);
}

}  // namespace clothsim_ros
