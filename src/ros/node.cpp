#include "clothsim/ros/node.h"

#include <ros/console.h>
#include <ros/init.h>
#include <rosgraph_msgs/Clock.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <utility>

#include "clothsim/geometry/intersections.h"
#include "clothsim/model/checks.h"
#include "clothsim/model/errors.h"

namespace clothsim_ros {
namespace {

/// The loop comes round at least this often, for diagnostics and for the end of the node.
const ros::WallDuration longest_wait(0.1);

/// While something else is waited for, at least so often.
const ros::WallDuration look_again(0.01);

/// A second of it, so that the frames of a ~step get through.
constexpr std::uint32_t clock_queue = 100;

/// Of a call of ~step, while which nothing else is served.
constexpr std::uint32_t most_frames = 1000000;

/// Says what a scene has and a node leaves to others.
void warn_of_motions(const clothsim::Scene& scene) {
  if (scene.motions.empty()) return;
  ROS_WARN(
      "The node does not play the scene's motions: give ~step targets, or broadcast tf frames");
}

/// Says what of its robots a scene goes without.
void warn_of_left_out(const clothsim::Scene& scene) {
  for (const std::string& line : scene.left_out) ROS_WARN("Left out: %s", line.c_str());
}

/// The same names, with callbacks that go to `queue`.
ros::NodeHandle with_queue(ros::NodeHandle node, ros::CallbackQueueInterface& queue) {
  node.setCallbackQueue(&queue);
  return node;
}

}  // namespace

Node::Node(const ros::NodeHandle& node, ros::CallbackQueue& queue, std::function<bool()> ends)
    : queue_(queue),
      ends_(std::move(ends)),
      callbacks_(queue, time_),
      node_(with_queue(node, callbacks_)),
      parameters_(read_parameters(node_)),
      simulator_(with_full_name(node_, "scene/",
                                [this] { return clothsim::Simulator(parameters_.scene); })),
      paused_(parameters_.paused),
      pacer_(parameters_.realtime_factor, parameters_.publish_clock),
      changes_(node_, pacer_, frame_number_),
      tf_(parameters_.world_frame, parameters_.limits.tf_age.warning),
      targets_(node_, tf_),
      follower_(parameters_.scene, tf_, parameters_.jump_speed),
      grasper_(node_, simulator_, tf_, changes_, pacer_, parameters_.jump_speed),
      outputs_(node_, simulator_, parameters_.world_frame, pacer_.now()),
      contact_topics_(node_, simulator_, parameters_.world_frame),
      photographer_(with_full_name(node_, "camera/",
                                   [this] {
                                     return Photographer(node_, simulator_, tf_, parameters_.view,
                                                         parameters_.image_folders, pacer_.now());
                                   })),
      state_services_(node_, simulator_, targets_, follower_, changes_, frame_number_,
                      parameters_.save_limit, [this] { jump(); }),
      stress_topic_(node_, simulator_, parameters_.world_frame),
      wind_listener_(node_, simulator_, tf_, changes_),
      force_listener_(node_, simulator_, tf_, changes_),
      diagnostics_(node_, parameters_.limits) {
  simulator_.set_interrupt([this] { return !is_running(); });
  const ParameterTexts given = parameter_texts(node_);
  serve_live_values();
  warn_of_ignored(given);
  warn_of_motions(parameters_.scene);
  warn_of_left_out(parameters_.scene);
  if (parameters_.publish_clock) {
    clock_publisher_ = node_.advertise<rosgraph_msgs::Clock>("/clock", clock_queue, true);
    publish_clock();
  }
  services_ = {node_.advertiseService("pause", &Node::pause, this),
               node_.advertiseService("reset", &Node::reset, this),
               node_.advertiseService("enable_collider", &Node::enable_collider, this),
               node_.advertiseService("load_scene", &Node::load_scene, this),
               node_.advertiseService("step", &Node::step, this)};
}

void Node::serve_live_values() {
  reconfigure_.emplace(node_, simulator_, changes_);
  view_reconfigure_.emplace(node_, photographer_, simulator_.scene());
}

void Node::warn_of_ignored(const ParameterTexts& given) const {
  KnownParameters known{parameter_names(), reconfigure_->names()};
  const std::vector<std::string>& of_view = view_reconfigure_->names();
  known.live.insert(known.live.end(), of_view.begin(), of_view.end());
  warn_of_ignored_parameters(node_, known, given);
}

void Node::run() {
  rate_.restart(pacer_.seconds());

  while (is_running()) {
    // Serve callbacks until the next frame is due.
    const ros::WallDuration wait =
        paused_ ? longest_wait : pacer_.until_due(simulator_.frame_duration());
    choice_log_.update(simulator_.scene().simulation, simulator_.choice());
    serve(std::min(wait, longest_wait));
    go_on();
  }
}

void Node::go_on() {
  refresh();
  const bool due = !paused_ && pacer_.until_due(simulator_.frame_duration()).isZero();
  if (due && is_running()) simulate_frame(Turn::due);
  publish_diagnostics();
}

void Node::go_on_beside(const std::function<void()>& action) {
  std::future<void> done = std::async(std::launch::async, action);
  const auto wait = [&] {
    const ros::WallDuration due = pacer_.until_due(simulator_.frame_duration());
    return std::chrono::nanoseconds(std::min(paused_ ? look_again : due, look_again).toNSec());
  };
  while (done.wait_for(wait()) != std::future_status::ready) {
    tf_.receive();
    go_on();
  }
  done.get();
}

bool Node::is_running() const { return !ends_() && ros::ok() && !ros::isShuttingDown(); }

void Node::serve(ros::WallDuration wait) {
  queue_.callOne(wait);
  queue_.callAvailable();
  const TimeShares::Scope scope(time_, TimeShares::Use::serving);
  tf_.receive();
}

bool Node::simulate_frame(Turn turn) {
  const TimeShares::Scope scope(time_, TimeShares::Use::simulating);
  const double frame_duration = simulator_.frame_duration();
  tf_.hold();
  follower_.look_up();
  follower_.tell(changes_);
  follower_.move(simulator_);
  grasper_.look_up();
  grasper_.move();
  contact_topics_.ask();
  force_listener_.end_when_due();
  try {
    report_ = simulator_.step();
  } catch (const clothsim::Interrupted&) {
    return false;  // the node ends
  } catch (const clothsim::Diverged& error) {
    failure_ = error.what();
    paused_ = true;
    ROS_ERROR("%s; paused at the last good frame, call ~reset or change the material",
              failure_.c_str());
    return false;
  }
  failure_.clear();
  if (report_.recoveries > 0) {
    ROS_WARN("A frame was taken back: %s. Now %s with %d substeps", report_.reasons.text().c_str(),
             report_.method.c_str(), report_.substeps);
  }
  ++frame_number_;
  rate_.add(frame_duration);
  const ros::Time stamp =
      turn == Turn::due ? pacer_.advance(frame_duration) : pacer_.advance_now(frame_duration);
  publish_frame(stamp);
  contact_topics_.publish(stamp, frame_number_);
  stress_topic_.publish(stamp, frame_number_);
  return true;
}

void Node::publish_frame(const ros::Time& stamp) {
  const TimeShares::Scope scope(time_, TimeShares::Use::publishing);
  publish_clock();  // first, so that no state comes from the future
  targets_.broadcast(stamp);
  outputs_.publish(stamp, frame_number_);
  grasper_.update(stamp);
  photographer_.update(stamp);
}

void Node::refresh() {
  const TimeShares::Scope scope(time_, TimeShares::Use::publishing);
  outputs_.refresh();
  photographer_.refresh(paused_);
}

void Node::jump() {
  failure_.clear();
  report_ = {};
  grasper_.follow_grips();
  publish_frame(pacer_.advance_now(simulator_.frame_duration()));
  rate_.restart(pacer_.seconds());
}

void Node::publish_clock() {
  if (!clock_publisher_) return;
  rosgraph_msgs::Clock msg;
  msg.clock = pacer_.now();
  clock_publisher_.publish(msg);
}

void Node::publish_diagnostics() {
  const ros::SteadyTime now = ros::SteadyTime::now();
  if (now < next_diagnostics_) return;
  next_diagnostics_ = now + ros::WallDuration(parameters_.diagnostic_period);

  const TimeShares::Scope scope(time_, TimeShares::Use::publishing);
  tf_.hold(true);
  follower_.look_up();  // a paused simulation does not
  grasper_.look_up();
  NodeStatus status;
  status.paused = paused_;
  status.waits_for_clock = !paused_ && pacer_.waits_for_clock();
  status.failure = failure_;
  status.factor_asked = parameters_.realtime_factor;
  if (!paused_) status.factor_reached = rate_.take(pacer_.seconds());
  status.time = time_.take();
  status.report = report_;
  status.strain_limit = simulator_.scene().cloth.material.strain_limit;
  if (simulator_.cloth().self_collision != clothsim::SelfCollision::off) {
    status.intersecting_pairs =
        clothsim::count_intersections(simulator_.cloth(), simulator_.state().positions);
  }
  status.frames = follower_.status();
  for (const FrameStatus& frame : grasper_.status()) status.frames.push_back(frame);
  status.camera = photographer_.status();
  diagnostics_.publish(status);
}

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
  outputs_.redraw();
  photographer_.redraw();
  response.success = true;
  return true;
}

void Node::start_with(const clothsim::Scene& scene) {
  const clothsim::View live_view = photographer_.view();
  clothsim::inside("camera", [&] {
    const clothsim::View view = clothsim::without_missing_colliders(parameters_.view, scene);
    go_on_beside([&] { photographer_.set_view(view); });  // which may read large images
  });
  try {
    clothsim::inside("scene", [&] { simulator_.load(scene); });
  } catch (const clothsim::InvalidValue&) {
    photographer_.set_view(live_view);
    throw;
  }
}

bool Node::load_scene(clothsim::LoadScene::Request&, clothsim::LoadScene::Response& response) {
  try {
    start_with(read_scene_parameter(node_));
  } catch (const clothsim::InvalidValue& error) {
    response.message = error.message(node_.getNamespace() + "/", "/");
    return true;
  }
  warn_of_motions(simulator_.scene());
  warn_of_left_out(simulator_.scene());
  changes_.publish("load_scene");
  targets_.reset(simulator_.scene());
  follower_ = FrameFollower(simulator_.scene(), tf_, parameters_.jump_speed);
  state_services_.clear();
  contact_topics_.follow_scene();
  serve_live_values();
  frame_number_ = 0;
  outputs_.refresh();  // the topology, before states on it
  jump();
  response.success = true;
  return true;
}

bool Node::step(clothsim::Step::Request& request, clothsim::Step::Response& response) {
  if (!paused_) {
    response.message = "the simulation is running: pause it first";
    return true;
  }
  try {
    if (request.frames < 1 || request.frames > most_frames) {
      throw clothsim::InvalidValue({"frames"}, std::to_string(request.frames),
                                   "a whole number from 1 to " + std::to_string(most_frames));
    }
    targets_.aim(request, simulator_);
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
    photographer_.wait();  // no picture is dropped, so that each run has the same ones
    publish_diagnostics();
  }
  photographer_.finish();
  return "";
}

}  // namespace clothsim_ros
