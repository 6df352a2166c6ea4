#include "clothsim/ros/node.h"

#include <ros/console.h>
#include <ros/init.h>
#include <rosgraph_msgs/Clock.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <utility>

#include "clothsim/geometry/intersections.h"
#include "clothsim/model/errors.h"
#include "clothsim/scene/doubts.h"
#include "clothsim/scene/fixed_values.h"

namespace clothsim_ros {
namespace {

/// Longest wait of the loop, for diagnostics and for the end of the node.
const ros::WallDuration longest_wait(0.1);

/// Longest wait between checks while waiting for something else.
const ros::WallDuration look_again(0.01);

/// A second's messages, so that the frames of a ~step get through.
constexpr std::uint32_t clock_queue = 100;

/// The same namespace, with callbacks that go to `queue`.
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
      cameras_(node_, parameters_.cameras, simulator_, tf_, parameters_.image_folders,
               pacer_.now()),
      body_topics_(node_, simulator_, grasper_, changes_, parameters_.world_frame,
                   [this] { redraw(); }),
      state_services_(node_, simulator_, targets_, follower_, changes_, frame_number_, paused_,
                      parameters_.save_limit, [this] { jump(); }),
      stress_topic_(node_, simulator_, parameters_.world_frame),
      wind_listener_(node_, simulator_, tf_, changes_),
      force_listener_(node_, simulator_, tf_, changes_),
      diagnostics_(node_, parameters_.limits) {
  simulator_.set_interrupt([this] { return !is_running(); });
  const ParameterTexts given = parameter_texts(node_);
  serve_live_values();
  warn_of_ignored(given);
  warn_of_scene(parameters_.scene_yaml);
  if (parameters_.publish_clock) {
    clock_publisher_ = node_.advertise<rosgraph_msgs::Clock>("/clock", clock_queue, true);
    publish_clock();
  }
  services_ = {node_.advertiseService("pause", &Node::pause, this),
               node_.advertiseService("reset", &Node::reset, this),
               node_.advertiseService("reset_values", &Node::reset_values, this),
               node_.advertiseService("enable_collider", &Node::enable_collider, this),
               node_.advertiseService("load_scene", &Node::load_scene, this),
               node_.advertiseService("step", &Node::step, this)};
}

void Node::serve_live_values() {
  changes_.set_scene(clothsim::fixed_values(simulator_.scene()));
  reconfigure_.emplace(node_, simulator_, changes_);
  view_reconfigure_.emplace(node_, cameras_, simulator_.scene());
}

void Node::warn_of_ignored(const ParameterTexts& given) const {
  KnownParameters known{parameter_names(), reconfigure_->names()};
  for (std::size_t i = 1; i < parameters_.cameras.size(); ++i) {
    known.read.push_back(parameters_.cameras[i].name);  // image_transport keeps parameters below
  }
  const std::vector<std::string>& of_view = view_reconfigure_->names();
  known.live.insert(known.live.end(), of_view.begin(), of_view.end());
  warn_of_ignored_parameters(node_, known, given);
}

void Node::warn_of_scene(const YAML::Node& given) const {
  const clothsim::Scene& scene = simulator_.scene();
  if (!scene.motions.empty()) {
    ROS_WARN(
        "The node does not play the scene's motions: give ~step targets, or broadcast tf frames");
  }
  for (const std::string& line : scene.left_out) ROS_WARN("Left out: %s", line.c_str());
  for (const std::string& line : clothsim::doubts(given, scene)) ROS_WARN("%s", line.c_str());
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
  if (pacer_.has_jumped()) {
    ROS_WARN("ROS time jumped ahead: the simulation goes on from there");
    rate_.restart(pacer_.seconds());
  }
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
  contact_topics_.ask(body_topics_.asks_for_wrenches());
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
  publish_clock();  // first, so that no state is ahead of the clock
  targets_.broadcast(stamp);
  body_topics_.publish(stamp, frame_number_);
  outputs_.publish(stamp, frame_number_);
  grasper_.update(stamp);
  cameras_.update(stamp);
}

void Node::refresh() {
  const TimeShares::Scope scope(time_, TimeShares::Use::publishing);
  outputs_.refresh();
  cameras_.refresh(paused_);
}

void Node::redraw() {
  outputs_.redraw();
  cameras_.redraw();
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
  follower_.look_up();  // a paused simulation does not look them up
  grasper_.look_up();
  NodeStatus status;
  status.paused = paused_;
  status.waits_for_clock = !paused_ && pacer_.waits_for_clock();
  status.failure = failure_;
  status.factor_asked = parameters_.realtime_factor;
  if (!paused_) status.factor_reached = rate_.take(pacer_.seconds());
  status.time = time_.take();
  status.report = report_;
  status.holders = simulator_.holders();
  status.is_limited = simulator_.cloth().strain_limit.has_value();
  if (simulator_.cloth().self_collision != clothsim::SelfCollision::off) {
    status.intersecting_pairs =
        clothsim::count_intersections(simulator_.cloth(), simulator_.state().positions);
  }
  status.frames = follower_.status();
  near_frames_.warn(status.frames, tf_);
  for (const FrameStatus& frame : grasper_.status()) status.frames.push_back(frame);
  status.cameras = cameras_.status();
  diagnostics_.publish(status);
}

}  // namespace clothsim_ros
