#include "clothsim/ros/reconfigure.h"

#include <clothsim/ClothConfig.h>
#include <clothsim/ClothSimConfig.h>
#include <clothsim/ColliderConfig.h>

#include <algorithm>
#include <utility>

#include "clothsim/model/checks.h"
#include "clothsim/ros/live_values.h"
#include "clothsim/ros/names.h"

namespace clothsim_ros {
namespace {

using Config = clothsim::ClothSimConfig;
using clothsim::ClothConfig;
using clothsim::ColliderConfig;
using OfCloth = clothsim::LiveSpec::OfCloth;

/// Calls visit(of the configuration, of the material) for each of a fabric's values.
template <typename Config, typename Fabric, typename Visit>
void for_each_value(Config& config, Fabric& fabric, Visit&& visit) {
  visit(config.stretch_stiffness_warp, fabric.stretch_stiffness[0]);
  visit(config.stretch_stiffness_weft, fabric.stretch_stiffness[1]);
  visit(config.shear_stiffness, fabric.shear_stiffness);
  visit(config.bending_stiffness_warp, fabric.bending_stiffness[0]);
  visit(config.bending_stiffness_weft, fabric.bending_stiffness[1]);
  visit(config.internal_damping_stretch, fabric.internal_damping[0]);
  visit(config.internal_damping_bending, fabric.internal_damping[1]);
  visit(config.poisson, fabric.poisson);
}

/// Calls visit(of the configuration, of the cloth) for each value of one of several cloths.
template <typename Config, typename Cloth, typename Visit>
void for_each_value_of_cloth(Config& config, Cloth& cloth, Visit&& visit) {
  for_each_value(config, *cloth.material.fabric, visit);
  visit(config.density, cloth.material.density);
  visit(config.damping, cloth.material.damping);
  visit(config.drag_across, cloth.material.drag[0]);
  visit(config.drag_along, cloth.material.drag[1]);
  visit(config.thickness, cloth.thickness);
  visit(config.friction, cloth.friction);
  visit(config.structural, cloth.material.springs[0]);
  visit(config.shear, cloth.material.springs[1]);
  visit(config.bending, cloth.material.springs[2]);
}

/// `config` with the values of one of several cloths. A strain limit that is off keeps its number.
template <typename Config>
Config with_values_of(const OfCloth& cloth, Config config) {
  for_each_value_of_cloth(config, cloth, [](auto& shown, const auto& value) { shown = value; });
  config.strain_limit_enabled = cloth.material.strain_limit.has_value();
  config.strain_limit = cloth.material.strain_limit.value_or(config.strain_limit);
  return config;
}

/// Sets the values of one of several cloths. Throws InvalidValue. A strain limit is checked even
/// while it is off, so that it can be switched on.
void set_values_of_cloth(ClothConfig config, OfCloth& cloth) {
  for_each_value_of_cloth(config, cloth, [](const auto& given, auto& value) { value = given; });
  cloth.material.strain_limit = config.strain_limit;
  clothsim::validate(cloth.material);
  if (!config.strain_limit_enabled) cloth.material.strain_limit.reset();
}

/// Sets a cloth's stiffness, or its fabric, from `config`. Throws where a value of the other kind
/// of cloth changes.
void set_stiffness(const Config& config, clothsim::Material& material) {
  if (material.fabric) {
    if (config.ks != material.ks) {
      throw clothsim::InvalidValue({"ks"}, clothsim::to_text(config.ks),
                                   "no change: the cloth is a fabric, of a stretch_stiffness");
    }
    for_each_value(config, *material.fabric, [](double given, double& value) { value = given; });
    return;
  }
  material.ks = config.ks;
  const clothsim::Fabric none;
  for_each_value(config, none, [](double given, double) {
    if (given == 0) return;
    throw clothsim::InvalidValue({"fabric"}, "a value of a fabric",
                                 "none: the cloth is of springs, of a stiffness ks");
  });
}

/// `config` with the values of `scene`. A strain limit that is off keeps its number.
Config from_scene(const clothsim::Scene& scene, Config config) {
  const clothsim::Material& material = scene.cloth.material;
  config.ks = material.ks;
  const clothsim::Fabric fabric = material.fabric.value_or(clothsim::Fabric());
  for_each_value(config, fabric, [](double& shown, double value) { shown = value; });
  config.drag_across = material.drag[0];
  config.drag_along = material.drag[1];
  config.density = material.density;
  config.damping = material.damping;
  config.structural = material.springs[static_cast<size_t>(clothsim::SpringFamily::structural)];
  config.shear = material.springs[static_cast<size_t>(clothsim::SpringFamily::shear)];
  config.bending = material.springs[static_cast<size_t>(clothsim::SpringFamily::bending)];
  config.strain_limit_enabled = material.strain_limit.has_value();
  config.strain_limit = material.strain_limit.value_or(config.strain_limit);

  config.thickness = scene.cloth.thickness;
  config.friction = scene.cloth.friction;
  config.self_collision =
      clothsim::self_collision_names[static_cast<size_t>(scene.cloth.self_collision)];

  const clothsim::SimulationSpec& simulation = scene.simulation;
  config.gravity_x = simulation.gravity.x();
  config.gravity_y = simulation.gravity.y();
  config.gravity_z = simulation.gravity.z();
  const clothsim::Vector3 wind = simulation.wind.value_or(clothsim::Vector3::Zero());
  config.wind_x = wind.x();
  config.wind_y = wind.y();
  config.wind_z = wind.z();
  config.gusts = simulation.gusts;
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

/// Adds values by their names below the node's, in namespace `ns`.
template <typename Generated>
void append(const Generated& config, const std::string& ns, dynamic_reconfigure::Config& msg) {
  dynamic_reconfigure::Config own;
  config.__toMessage__(own);
  const auto add = [&](const auto& values, auto& to) {
    for (auto value : values) {
      value.name = ns + '/' + value.name;
      to.push_back(value);
    }
  };
  add(own.bools, msg.bools);
  add(own.doubles, msg.doubles);
}

/// A server of values in a namespace below the node's.
template <typename Generated>
struct Space {
  std::string ns;
  std::unique_ptr<LiveValues<Generated>> values;
};

clothsim::Vector3 wind_of(const Config& config) {
  return {config.wind_x, config.wind_y, config.wind_z};
}

clothsim::SelfCollision to_self_collision(const std::string& name) {
  // As in scenes; dynparam passes YAML's true on in Python's notation.
  if (name == "true" || name == "True") return clothsim::SelfCollision::automatic;
  if (name == "false" || name == "False") return clothsim::SelfCollision::off;
  const auto& names = clothsim::self_collision_names;
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    throw clothsim::InvalidValue({"self_collision"}, '"' + name + '"',
                                 "one of " + clothsim::join({names.begin(), names.end()}));
  }
  return static_cast<clothsim::SelfCollision>(found - names.begin());
}

/// `scene` with the values of `config`. A wind equal to that of `last` is left out, as ~wind may
/// have set another one. The method of `start` gets the parameters of `start`.
clothsim::Scene to_scene(const Config& config, const Config& last,
                         const clothsim::SimulationSpec& start, clothsim::Scene scene) {
  clothsim::Material& material = scene.cloth.material;
  set_stiffness(config, material);
  material.drag = {config.drag_across, config.drag_along};
  material.density = config.density;
  material.damping = config.damping;
  material.springs = {config.structural, config.shear, config.bending};
  material.strain_limit = config.strain_limit;

  scene.cloth.thickness = config.thickness;
  scene.cloth.friction = config.friction;
  scene.cloth.self_collision = to_self_collision(config.self_collision);

  clothsim::SimulationSpec& simulation = scene.simulation;
  simulation.gravity = {config.gravity_x, config.gravity_y, config.gravity_z};
  if (wind_of(config) != wind_of(last)) simulation.wind = wind_of(config);
  simulation.gusts = config.gusts;
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
  Impl(const ros::NodeHandle& node, clothsim::Simulator& served, Changes& publisher)
      : simulator(served),
        changes(publisher),
        last(from_scene(simulator.scene(), Config::__getDefault__())),
        values(node, last, [this, start = simulator.scene().simulation](const Config& config) {
          const clothsim::Scene scene = to_scene(config, last, start, simulator.scene());
          simulator.set(clothsim::live_values(scene));
          last = config;
          if (!serving) return;
          show_cloths();
          clothsim::Change change;
          change.values = to_message(config);
          changes.publish("set_parameters", change);
        }) {
    const std::vector<std::string> cloth_names = ros_names(simulator.scene().cloth.parts);
    for (std::size_t i = 0; i < cloth_names.size(); ++i) {
      add_cloth(node, i, "cloth/" + cloth_names[i]);
    }
    const std::vector<clothsim::ColliderSpec>& specs = simulator.scene().colliders;
    const std::vector<std::string> in_ros = ros_names(specs);
    for (std::size_t i = 0; i < specs.size(); ++i) {
      add_collider(node, specs[i].name, "collider/" + in_ros[i]);
    }
    serving = true;
  }

  /// Serves the values of a collider in namespace `ns`.
  void add_collider(const ros::NodeHandle& node, const std::string& name, const std::string& ns) {
    ColliderConfig start;
    start.friction = clothsim::live_values(simulator.scene()).collider_friction.at(name);
    const auto apply = [this, name, ns](const ColliderConfig& config) {
      if (!serving) return;  // in effect already
      clothsim::LiveSpec live = clothsim::live_values(simulator.scene());
      clothsim::validate_contact(live.thickness, config.friction);  // to name this value in errors
      live.collider_friction[name] = config.friction;
      simulator.set(live);
      clothsim::Change change;
      append(config, ns, change.values);
      changes.publish("set_parameters", change);
    };
    colliders.push_back({ns, std::make_unique<LiveValues<ColliderConfig>>(ros::NodeHandle(node, ns),
                                                                          start, apply)});
  }

  /// Serves the values of one of several cloths in namespace `ns`.
  void add_cloth(const ros::NodeHandle& node, std::size_t index, const std::string& ns) {
    const auto apply = [this, index, ns](const ClothConfig& config) {
      if (!serving) return;  // in effect already
      clothsim::LiveSpec live = clothsim::live_values(simulator.scene());
      set_values_of_cloth(config, live.cloths[index]);
      simulator.set(live);
      if (index == 0) {  // which the node's own values show
        last = with_values_of(live.cloths[0], last);
        values.show(last);
      }
      clothsim::Change change;
      append(config, ns, change.values);
      changes.publish("set_parameters", change);
    };
    const ClothConfig start = with_values_of(clothsim::live_values(simulator.scene()).cloths[index],
                                             ClothConfig::__getDefault__());
    cloths.push_back(
        {ns, std::make_unique<LiveValues<ClothConfig>>(ros::NodeHandle(node, ns), start, apply)});
  }

  /// Gives several cloths their values of the start, all at once: the values of one may be refused
  /// for another.
  void reset_cloths() {
    const auto is_changed = [](const auto& space) { return !space.values->changed().empty(); };
    if (std::none_of(cloths.begin(), cloths.end(), is_changed)) return;
    clothsim::LiveSpec live = clothsim::live_values(simulator.scene());
    for (std::size_t i = 0; i < cloths.size(); ++i) {
      set_values_of_cloth(cloths[i].values->start(), live.cloths[i]);
    }
    live.material = live.cloths.front().material;
    live.friction = live.cloths.front().friction;
    live.thickness = live.cloths.front().thickness;
    simulator.set(live);
    last = with_values_of(live.cloths.front(), last);
    values.show(last);
    for (std::size_t i = 0; i < cloths.size(); ++i) {
      cloths[i].values->show(with_values_of(live.cloths[i], cloths[i].values->start()));
    }
    clothsim::Change change;
    for (const auto& [ns, of_cloth] : cloths) append(of_cloth->accepted(), ns, change.values);
    changes.publish("set_parameters", change);
  }

  void show_cloths() {
    const clothsim::LiveSpec live = clothsim::live_values(simulator.scene());
    for (std::size_t i = 0; i < cloths.size(); ++i) {
      cloths[i].values->show(with_values_of(live.cloths[i], cloths[i].values->accepted()));
    }
  }

  /// Calls visit(namespace, server) for those of cloths and colliders.
  template <typename Visit>
  void for_each_space(const Visit& visit) const {
    for (const auto& [ns, values_of_cloth] : cloths) visit(ns, *values_of_cloth);
    for (const auto& [ns, values_of_collider] : colliders) visit(ns, *values_of_collider);
  }

  clothsim::Simulator& simulator;
  Changes& changes;
  bool serving = false;  // false at the start, which is no call
  Config last;           // accepted last
  LiveValues<Config> values;
  std::vector<Space<ClothConfig>> cloths;  // of several
  std::vector<Space<ColliderConfig>> colliders;
};

Reconfigure::Reconfigure(const ros::NodeHandle& node, clothsim::Simulator& simulator,
                         Changes& changes)
    : impl_(std::make_unique<Impl>(node, simulator, changes)) {}

Reconfigure::~Reconfigure() = default;

dynamic_reconfigure::Config Reconfigure::values() const {
  dynamic_reconfigure::Config msg = to_message(impl_->values.accepted());
  impl_->for_each_space(
      [&](const std::string& ns, const auto& values) { append(values.accepted(), ns, msg); });
  return msg;
}

std::vector<std::string> Reconfigure::changed() const {
  std::vector<std::string> all = impl_->values.changed();
  impl_->for_each_space([&](const std::string& ns, auto& values) {
    for (const std::string& text : values.changed()) all.push_back(ns + '/' + text);
  });
  return all;
}

void Reconfigure::reset() {
  impl_->reset_cloths();
  impl_->values.reset();
  for (const auto& [ns, values] : impl_->colliders) values->reset();
}

std::vector<std::string> Reconfigure::names() const {
  std::vector<std::string> all = LiveValues<Config>::names();
  impl_->for_each_space([&](const std::string& ns, const auto& values) {
    for (const std::string& name : values.names()) all.push_back(ns + '/' + name);
  });
  return all;
}

}  // namespace clothsim_ros
