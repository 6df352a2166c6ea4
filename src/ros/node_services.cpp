// The services of the node.

#include <ros/console.h>

#include <algorithm>

#include "clothsim/model/checks.h"
#include "clothsim/model/errors.h"
#include "clothsim/ros/live_values.h"
#include "clothsim/ros/node.h"
#include "clothsim/ros/scene_parameter.h"

namespace clothsim_ros {
namespace {

/// Most frames of a call of ~step: during the call nothing else is served.
constexpr std::uint32_t max_frames = 1000000;

}  // namespace

bool Node::pause(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response) {
  const bool resumes = paused_ && !request.data;
  paused_ = request.data;
  if (resumes) {
    pacer_.restart();
    rate_.restart(pacer_.seconds());
  }
  response.success = true;
  response.message = paused_ ? "paused" : "running";
  return true;
}

bool Node::reset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  clothsim::Change change;
  change.values = reconfigure_->values();
  changes_.publish("reset", change);
  simulator_.reset();
  targets_.reset(simulator_.scene());
  follower_.reset();
  frame_number_ = 0;
  wind_listener_.tell();
  jump();
  response.success = true;
  response.message = "at the scene's start";
  const std::vector<std::string> live = reconfigure_->changed();
  if (!live.empty()) {
    response.message += ", with live values that are not the scene's: " + clothsim::join(live) +
                        "; ~reset_values takes them back";
  }
  return true;
}

bool Node::reset_values(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  std::vector<std::string> changed = reconfigure_->changed();
  for (const std::string& text : view_reconfigure_->changed()) changed.push_back(text);
  try {
    reconfigure_->reset();
    go_on_beside([&] { view_reconfigure_->reset(); });  // which may read large images
  } catch (const clothsim::InvalidValue& error) {
    response.message = live_message(error, node_.getNamespace());
    return true;
  }
  response.success = true;
  response.message = changed.empty()
                         ? "as the scene has them"
                         : "as the scene has them again: " + clothsim::join(changed) + " were not";
  return true;
}

bool Node::enable_collider(clothsim::EnableCollider::Request& request,
                           clothsim::EnableCollider::Response& response) {
  const std::vector<clothsim::ColliderSpec>& colliders = simulator_.scene().colliders;
  const auto collider =
      std::find_if(colliders.begin(), colliders.end(),
                   [&](const clothsim::ColliderSpec& c) { return c.name == request.name; });
  if (collider == colliders.end()) {
    std::vector<std::string> names;
    for (const clothsim::ColliderSpec& c : colliders) names.push_back(c.name);
    response.message = clothsim::InvalidValue({"name"}, '"' + request.name + '"',
                                              names.empty() ? "none, as the scene has no colliders"
                                                            : "one of " + clothsim::join(names))
                           .what();
    return true;
  }
  clothsim::Change change;
  change.collider = request.name;
  change.enabled = request.enabled;
  changes_.publish("enable_collider", change);
  simulator_.enable_collider(static_cast<int>(collider - colliders.begin()), request.enabled);
  redraw();
  response.success = true;
  return true;
}

void Node::start_with(const clothsim::Scene& scene) {
  const std::vector<clothsim::View> live_views = cameras_.views();
  std::vector<clothsim::View> views;
  for (const clothsim::NamedView& camera : parameters_.cameras) {
    views.push_back(clothsim::without_missing_names(camera.view, scene));
  }
  go_on_beside([&] { cameras_.set_views(views); });  // which may read large images
  try {
    clothsim::inside("scene", [&] { simulator_.load(scene); });
  } catch (const clothsim::InvalidValue&) {
    cameras_.set_views(live_views);
    throw;
  }
}

bool Node::load_scene(clothsim::LoadScene::Request& request,
                      clothsim::LoadScene::Response& response) {
  GivenScene given;
  try {
    given = request.file.empty() ? read_scene_parameter(node_) : read_scene_file(request.file);
    start_with(given.scene);
    tell_scene(node_, given);
  } catch (const clothsim::InvalidValue& error) {
    response.message = error.message(node_.getNamespace() + "/", "/");
    return true;
  }
  warn_of_scene(given.yaml);
  changes_.publish("load_scene");
  targets_.reset(simulator_.scene());
  follower_ = FrameFollower(simulator_.scene(), tf_, parameters_.jump_speed);
  state_services_.clear();
  contact_topics_.follow_scene();
  body_topics_.follow_scene();
  serve_live_values();
  frame_number_ = 0;
  outputs_.refresh();  // the topology, before its states
  jump();
  response.success = true;
  return true;
}

std::vector<std::string> Node::followed_frames() const {
  std::vector<std::string> names;
  for (const FrameStatus& frame : follower_.status()) names.push_back(frame.frame);
  for (const FrameStatus& frame : grasper_.status()) names.push_back(frame.frame);
  for (const clothsim::View& view : cameras_.views()) {
    if (!view.frame.empty()) names.push_back(view.frame);
  }
  return names;
}

bool Node::step(clothsim::Step::Request& request, clothsim::Step::Response& response) {
  if (!paused_) {
    response.message = "the simulation is running: pause it first";
    return true;
  }
  try {
    if (request.frames < 1 || request.frames > max_frames) {
      throw clothsim::InvalidValue({"frames"}, std::to_string(request.frames),
                                   "a whole number from 1 to " + std::to_string(max_frames));
    }
    targets_.set_targets(request, simulator_, followed_frames());
  } catch (const clothsim::InvalidValue& error) {
    response.message = error.message("", "/");
    return true;
  }
  response.message = simulate_frames(request);
  targets_.stop();
  response.success = response.message.empty();
  if (response.success) response.state = outputs_.state();
  return true;
}

std::string Node::simulate_frames(const clothsim::Step::Request& request) {
  if (!request.targets.empty()) {
    follower_.look_up();
    follower_.take_up(simulator_, changes_);
  }
  for (std::uint32_t i = 0; i < request.frames; ++i) {
    if (!is_running()) return "the node is shutting down";
    targets_.advance();
    if (!simulate_frame(Turn::now)) return failure_;
    cameras_.wait();  // no picture is dropped, so that each run has the same ones
    publish_diagnostics();
  }
  cameras_.finish();
  return "";
}

}  // namespace clothsim_ros
