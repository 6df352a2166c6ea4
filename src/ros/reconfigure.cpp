#include "clothsim/ros/reconfigure.h"

#include <clothsim/ClothSimConfig.h>
#include <dynamic_reconfigure/server.h>

#include <array>
#include <string>

#include "clothsim/model/errors.h"

namespace clothsim_ros {
namespace {

/// The limits of the .cfg are for sliders. The server would move a value beyond them to the limit
/// without a word; the scene's own checks are to accept or refuse it as it is.
struct Config : clothsim::ClothSimConfig {
  Config() = default;
  Config(const clothsim::ClothSimConfig& config) : clothsim::ClothSimConfig(config) {}
  void __clamp__() {}  // NOLINT(bugprone-reserved-identifier): the library's name
};

/// `config` with the values of `scene`. A strain limit that is off keeps its number.
Config from_scene(const clothsim::Scene& scene, Config config) {
  const clothsim::Material& material = scene.cloth.material;
  config.ks = material.ks;
  config.density = material.density;
  config.damping = material.damping;
  config.structural = material.springs[static_cast<size_t>(clothsim::SpringFamily::structural)];
  config.shear = material.springs[static_cast<size_t>(clothsim::SpringFamily::shear)];
  config.bending = material.springs[static_cast<size_t>(clothsim::SpringFamily::bending)];
  config.strain_limit_enabled = material.strain_limit.has_value();
  config.strain_limit = material.strain_limit.value_or(config.strain_limit);

  const clothsim::SimulationSpec& simulation = scene.simulation;
  config.gravity_x = simulation.gravity.x();
  config.gravity_y = simulation.gravity.y();
  config.gravity_z = simulation.gravity.z();
  config.frames_per_second = simulation.frames_per_second;
  config.substeps = simulation.substeps.value_or(0);
  return config;
}

/// `scene` with the values of `config`.
clothsim::Scene to_scene(const Config& config, clothsim::Scene scene) {
  clothsim::Material& material = scene.cloth.material;
  material.ks = config.ks;
  material.density = config.density;
  material.damping = config.damping;
  material.springs = {config.structural, config.shear, config.bending};
  material.strain_limit = config.strain_limit;

  clothsim::SimulationSpec& simulation = scene.simulation;
  simulation.gravity = {config.gravity_x, config.gravity_y, config.gravity_z};
  simulation.frames_per_second = config.frames_per_second;
  simulation.substeps.reset();
  if (config.substeps != 0) simulation.substeps = config.substeps;

  // A strain limit is checked even while it is off, so that it can be switched on.
  clothsim::validate(scene);
  if (!config.strain_limit_enabled) material.strain_limit.reset();
  return scene;
}

/// The message with the name of the live parameter: {"simulation", "gravity", "2"} is gravity_z.
std::string live_message(const clothsim::InvalidValue& error, const std::string& ns) {
  const std::vector<std::string>& key = error.key();
  std::string name = key.back();
  if (key.size() >= 2 && key[key.size() - 2] == "gravity") {
    name = std::string("gravity_") + "xyz"[std::stoul(name)];
  }
  const std::string full_name = ns + "/" + name;
  const std::string scene_name = error.message("", "/");
  return full_name + scene_name.substr(scene_name.find(": got"));
}

}  // namespace

struct Reconfigure::Impl {
  Impl(const ros::NodeHandle& node_handle, clothsim::Simulator& sim)
      : node(node_handle), simulator(sim), server(mutex, node) {
    accepted = from_scene(simulator.scene(), Config::__getDefault__());
    server.updateConfig(accepted);
    server.setCallback([this](Config& config, std::uint32_t) { apply(config); });
  }

  void apply(Config& config) {
    try {
      const clothsim::Scene scene = to_scene(config, simulator.scene());
      simulator.set(scene.cloth.material, scene.simulation);
      accepted = config;
    } catch (const clothsim::InvalidValue& error) {
      ROS_ERROR("%s", live_message(error, node.getNamespace()).c_str());
      config = accepted;
    }
  }

  ros::NodeHandle node;
  clothsim::Simulator& simulator;
  Config accepted;  // the simulator's values
  boost::recursive_mutex mutex;
  dynamic_reconfigure::Server<Config> server;
};

Reconfigure::Reconfigure(const ros::NodeHandle& node, clothsim::Simulator& simulator)
    : impl_(std::make_unique<Impl>(node, simulator)) {}

Reconfigure::~Reconfigure() = default;

}  // namespace clothsim_ros
