#include "clothsim/ros/view_reconfigure.h"

#include <clothsim/LightConfig.h>
#include <clothsim/ShadingConfig.h>
#include <clothsim/ViewpointConfig.h>
#include <ros/callback_queue.h>
#include <ros/spinner.h>

#include <functional>
#include <list>
#include <set>
#include <string>
#include <vector>

#include "clothsim/ros/live_values.h"
#include "clothsim/ros/names.h"
#include "clothsim/view/view_yaml.h"

namespace clothsim_ros {
namespace {

using clothsim::LightConfig;
using clothsim::ShadingConfig;
using clothsim::View;
using clothsim::ViewpointConfig;

// Visit each pair of a live value and a value of the view. The same list works in both directions,
// as `visit` is to_config or to_view.

template <class Vector, class Visit>
void visit_vector(Vector& vector, double& x, double& y, double& z, Visit visit) {
  visit(x, vector[0]);
  visit(y, vector[1]);
  visit(z, vector[2]);
}

template <class Visit>
void visit_look(ShadingConfig& config, clothsim::Look& look, Visit visit) {
  visit(config.shader, look.shader);
  visit_vector(look.color, config.color_r, config.color_g, config.color_b, visit);
  visit(config.ka, look.phong.ka);
  visit(config.kd, look.phong.kd);
  visit(config.ks, look.phong.ks);
  visit(config.power, look.phong.power);
  visit(config.ambient, look.phong.ambient);
  visit(config.diffuse, look.phong.diffuse);
  visit(config.specular, look.phong.specular);
  visit(config.texture, look.texture);
  visit(config.height_map, look.height_map);
  visit(config.environment, look.environment);
  visit(config.height_scaling, look.height_scaling);
  visit(config.normal_scaling, look.normal_scaling);
  visit(config.alpha, look.alpha);
  visit(config.by_light, look.by_light);
  visit(config.levels, look.levels);
  visit(config.structural, look.springs[0]);
  visit(config.shear, look.springs[1]);
  visit(config.bending, look.springs[2]);
}

template <class Visit>
void visit_collider(ShadingConfig& config, clothsim::ColliderLook& collider, Visit visit) {
  visit_look(config, collider.look, visit);
  visit(config.segments, collider.segments);
  visit(config.extent, collider.extent);
}

template <class Visit>
void visit_light(LightConfig& config, View& view, Visit visit) {
  visit_vector(view.light.position, config.position_x, config.position_y, config.position_z, visit);
  visit(config.intensity, view.light.intensity);
  visit(config.ambient, view.light.ambient);
  visit(config.shadows, view.light.shadows);
  visit_vector(view.background, config.background_r, config.background_g, config.background_b,
               visit);
  visit(config.sky, view.sky);
}

template <class Visit>
void visit_viewpoint(ViewpointConfig& config, View& view, Visit visit) {
  visit_vector(view.eye, config.eye_x, config.eye_y, config.eye_z, visit);
  visit_vector(view.target, config.target_x, config.target_y, config.target_z, visit);
  visit(config.frame, view.frame);
  visit(config.rate, view.rate);
  visit(config.each_step, view.each_step);
  visit(config.width, view.camera.width);
  visit(config.height, view.camera.height);
  visit(config.fx, view.camera.fx);
  visit(config.fy, view.camera.fy);
  visit(config.cx, view.camera.cx);
  visit(config.cy, view.camera.cy);
  visit(config.near, view.camera.near);
  visit(config.far, view.camera.far);
}

ShadingConfig config_of(clothsim::Look look) {
  ShadingConfig config = ShadingConfig::__getDefault__();
  visit_look(config, look, [](auto& shown, const auto& value) { shown = value; });
  return config;
}

/// Sets in `to` the values that `after` has changed since `before`.
void take_changes(const clothsim::Look& before, const clothsim::Look& after, clothsim::Look& to) {
  const ShadingConfig last = config_of(before), now = config_of(after);
  ShadingConfig config = config_of(to);
  for (const auto& value : ShadingConfig::__getParamDescriptions__()) {
    dynamic_reconfigure::Config old_value, new_value;
    value->toMessage(old_value, last);
    value->toMessage(new_value, now);
    if (old_value != new_value) value->fromMessage(new_value, config);
  }
  visit_look(config, to, [](const auto& given, auto& value) { value = given; });
}

const auto to_config = [](auto& config, const auto& value) { config = value; };
const auto to_view = [](const auto& config, auto& value) { value = config; };

}  // namespace

struct ViewReconfigure::Impl {
  using Change = std::function<void(View&)>;

  Impl(const ros::NodeHandle& node_handle, Cameras& c, const clothsim::Scene& scene)
      : node(node_handle), cameras(c) {
    node.setCallbackQueue(&queue);
    const auto looks = [this](const Change& change) { cameras.change_looks(change); };
    add(light, "light", looks, 0, [](LightConfig& config, View& view, auto direction) {
      visit_light(config, view, direction);
    });
    const std::vector<std::string> names_of_cameras = cameras.names();
    for (std::size_t i = 0; i < names_of_cameras.size(); ++i) {
      const std::string& camera = names_of_cameras[i];
      const std::string ns = i == 0 ? "viewpoint" : camera + "/viewpoint";
      const auto one = [this, camera](const Change& change) {
        cameras.change_view(camera, change);
      };
      add(viewpoint, ns, one, i, [](ViewpointConfig& config, View& view, auto direction) {
        visit_viewpoint(config, view, direction);
      });
    }
    add_cloths(scene.cloth.parts);
    std::set<std::string> taken{"cloth"};
    for (const std::string& name : ros_names(scene.cloth.parts, {"cloth"})) taken.insert(name);
    const std::vector<std::string> in_ros = ros_names(scene.colliders, taken);
    for (std::size_t i = 0; i < in_ros.size(); ++i) {
      const auto visit = [name = scene.colliders[i].name](ShadingConfig& config, View& view,
                                                          auto direction) {
        // A collider that the view does not name has the look of all.
        const auto look = view.colliders.emplace(name, view.collider).first;
        visit_collider(config, look->second, direction);
      };
      add(shading, "shading/" + in_ros[i], looks, 0, visit);
    }
    spinner.start();
  }

  /// Serves the look of the cloth, or of all of several cloths, and that of each.
  void add_cloths(const std::vector<clothsim::ClothPart>& parts) {
    const auto of_all = [this](const Change& change) {
      cameras.change_looks([&](View& view) {
        const clothsim::Look before = view.cloth;
        change(view);
        for (auto& named : view.cloths) take_changes(before, view.cloth, named.second);
      });
      for (const auto& show : show_cloths) show();
    };
    add(shading, "shading/cloth", of_all, 0, [](ShadingConfig& config, View& view, auto direction) {
      visit_look(config, view.cloth, direction);
    });

    const auto of_one = [this](const Change& change) { cameras.change_looks(change); };
    const std::vector<std::string> in_ros = ros_names(parts, {"cloth"});
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const auto visit = [name = parts[i].name](ShadingConfig& config, View& view, auto direction) {
        // A cloth that the view does not name has the look of all.
        visit_look(config, view.cloths.emplace(name, view.cloth).first->second, direction);
      };
      add(shading, "shading/" + in_ros[i], of_one, 0, visit);
      show_cloths.push_back([this, visit, &server = shading.back()] {
        ShadingConfig config = server.accepted();
        View view = cameras.views()[0];
        visit(config, view, to_config);
        server.show(config);
      });
    }
  }

  /// Serves the values that `visit` visits in namespace `ns`. `apply` changes views; `camera` gives
  /// the initial values.
  template <class Generated, class Apply, class Visit>
  void add(std::list<LiveValues<Generated>>& servers, const std::string& ns, Apply apply,
           std::size_t camera, Visit visit) {
    for (const std::string& name : LiveValues<Generated>::names()) names.push_back(ns + '/' + name);
    Generated start = Generated::__getDefault__();
    View view = cameras.views()[camera];
    visit(start, view, to_config);
    servers.emplace_back(ros::NodeHandle(node, ns), start, [apply, visit](Generated config) {
      apply([&](View& changed) {
        visit(config, changed, to_view);
        clothsim::validate(changed);
      });
    });
    spaces.push_back({ns, [&server = servers.back()] { return server.changed(); },
                      [&server = servers.back()] { server.reset(); }});
  }

  /// A namespace, and the task of its server.
  struct Space {
    std::string ns;
    std::function<std::vector<std::string>()> changed;
    std::function<void()> reset;
  };

  ros::CallbackQueue queue;  // of calls that may read images, for which frames do not wait
  ros::NodeHandle node;
  Cameras& cameras;
  std::vector<std::string> names;
  std::vector<Space> spaces;
  std::list<LiveValues<LightConfig>> light;
  std::list<LiveValues<ViewpointConfig>> viewpoint;
  std::list<LiveValues<ShadingConfig>> shading;    // of cloths, then of colliders
  std::vector<std::function<void()>> show_cloths;  // tell clients the looks of several
  ros::AsyncSpinner spinner{1, &queue};            // last, as its thread serves the others
};

ViewReconfigure::ViewReconfigure(const ros::NodeHandle& node, Cameras& cameras,
                                 const clothsim::Scene& scene)
    : impl_(std::make_unique<Impl>(node, cameras, scene)) {}

ViewReconfigure::~ViewReconfigure() = default;

const std::vector<std::string>& ViewReconfigure::names() const { return impl_->names; }

std::vector<std::string> ViewReconfigure::changed() {
  std::vector<std::string> all;
  for (const Impl::Space& space : impl_->spaces) {
    for (const std::string& text : space.changed()) all.push_back(space.ns + '/' + text);
  }
  return all;
}

void ViewReconfigure::reset() {
  for (const Impl::Space& space : impl_->spaces) space.reset();
}

}  // namespace clothsim_ros
