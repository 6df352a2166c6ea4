#include "clothsim/ros/reconfigure.h"

#include <clothsim/ClothSimConfig.h>

#include "clothsim/ros/live_values.h"

namespace clothsim_ros {
namespace {

using Config = clothsim::ClothSimConfig;

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
  config.method = simulation.method;
  return config;
}

dynamic_reconfigure::Config to_message(const Config& config) {
  dynamic_reconfigure::Config msg;
  config.__toMessage__(msg);
  return msg;
}

/// `scene` with the values of `config`. The method of `start` has its parameters from there.
clothsim::Scene to_scene(const Config& config, const clothsim::SimulationSpec& start,
                         clothsim::Scene scene) {
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
  if (config.substeps < 0) {
    throw clothsim::InvalidValue({"substeps"}, std::to_string(config.substeps),
                                 "0, for auto, or a whole number of at least 1");
  }
  if (config.substeps != 0) simulation.substeps = config.substeps;
  simulation.method = config.method;
  simulation.method_parameters = {};
  if (config.method == start.method) simulation.method_parameters = start.method_parameters;

  // A strain limit is checked even while it is off, so that it can be switched on.
  clothsim::validate(scene);
  if (!config.strain_limit_enabled) material.strain_limit.reset();
  return scene;
}

}  // namespace

struct Reconfigure::Impl {
  Impl(const ros::NodeHandle& node, clothsim::Simulator& simulator, Changes& changes)
      : values(node, from_scene(simulator.scene(), Config::__getDefault__()),
               [this, &simulator, &changes,
                start = simulator.scene().simulation](const Config& config) {
                 const clothsim::Scene scene = to_scene(config, start, simulator.scene());
                 simulator.set(scene.cloth.material, scene.simulation);
                 if (!serving) return;
                 clothsim::Change change;
                 change.values = to_message(config);
                 changes.publish("set_parameters", change);
               }) {
    serving = true;
  }

  bool serving = false;  // the start is no call
  LiveValues<Config> values;
};

Reconfigure::Reconfigure(const ros::NodeHandle& node, clothsim::Simulator& simulator,
                         Changes& changes)
    : impl_(std::make_unique<Impl>(node, simulator, changes)) {}

Reconfigure::~Reconfigure() = default;

dynamic_reconfigure::Config Reconfigure::values() const {
  return to_message(impl_->values.accepted());
}

std::vector<std::string> Reconfigure::names() { return LiveValues<Config>::names(); }

}  // namespace clothsim_ros
