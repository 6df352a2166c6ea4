#pragma once

#include <clothsim/EnableCollider.h>
#include <clothsim/LoadScene.h>
#include <clothsim/Step.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/ros/body_topics.h"
#include "clothsim/ros/cameras.h"
#include "clothsim/ros/changes.h"
#include "clothsim/ros/choice_log.h"
#include "clothsim/ros/contact_topics.h"
#include "clothsim/ros/diagnostics.h"
#include "clothsim/ros/force_listener.h"
#include "clothsim/ros/frame_follower.h"
#include "clothsim/ros/grasper.h"
#include "clothsim/ros/ignored_parameters.h"
#include "clothsim/ros/near_frames.h"
#include "clothsim/ros/outputs.h"
#include "clothsim/ros/pacer.h"
#include "clothsim/ros/parameters.h"
#include "clothsim/ros/reconfigure.h"
#include "clothsim/ros/state_services.h"
#include "clothsim/ros/step_targets.h"
#include "clothsim/ros/stress_topic.h"
#include "clothsim/ros/time_shares.h"
#include "clothsim/ros/view_reconfigure.h"
#include "clothsim/ros/wind_listener.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// A simulated cloth as a ROS node or nodelet. One thread serves the callbacks and, between them,
/// computes the frames, so nothing changes within a frame.
class Node {
 public:
  /// `node`: namespace of topics, services and parameters. `queue`: the callbacks; nobody else may
  /// call them. The node ends when `ends` returns true. Throws std::runtime_error with the full
  /// name of a bad parameter.
  Node(const ros::NodeHandle& node, ros::CallbackQueue& queue, std::function<bool()> ends);

  /// Simulates until the node is shut down. To be called in the thread of the constructor.
  void run();

 private:
  /// A frame that is due by the clock, or an extra one from ~step.
  enum class Turn { due, now };

  /// Simulates the frame that is due, and publishes due messages.
  void go_on();
  /// Runs `action` in a thread of its own, and simulates frames until it has ended. Throws its
  /// exceptions. Callbacks wait.
  void go_on_beside(const std::function<void()>& action);
  /// False when ROS is shut down or shutting down, or when the node is to end.
  bool is_running() const;
  /// Calls the callbacks in the queue, or those that come within `wait`.
  void serve(ros::WallDuration wait);
  /// Computes a frame and publishes it. False if it diverged; then the simulation is paused.
  bool simulate_frame(Turn);
  void publish_frame(const ros::Time& stamp);
  /// Publishes due messages between frames.
  void refresh();
  /// To be called when a collider has changed without a frame.
  void redraw();
  /// To be called when the simulator's state changes without a frame.
  void jump();
  void publish_clock();
  void serve_live_values();
  /// Loads another scene, with the view of ~camera at the node's start. Throws InvalidValue without
  /// a change where one of the two is refused.
  void start_with(const clothsim::Scene&);
  /// Warns of private parameters that were `given` without effect, once live values are served.
  void warn_of_ignored(const ParameterTexts& given) const;
  /// Warns of the scene's motions, which the node does not play, of parts that are left out, and of
  /// probable mistakes in the scene as `given`.
  void warn_of_scene(const YAML::Node& given) const;
  void publish_diagnostics();
  /// The tf frames of colliders, points and cameras.
  std::vector<std::string> followed_frames() const;

  bool pause(std_srvs::SetBool::Request&, std_srvs::SetBool::Response&);
  bool reset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response&);
  bool reset_values(std_srvs::Trigger::Request&, std_srvs::Trigger::Response&);
  bool enable_collider(clothsim::EnableCollider::Request&, clothsim::EnableCollider::Response&);
  bool load_scene(clothsim::LoadScene::Request&, clothsim::LoadScene::Response&);
  bool step(clothsim::Step::Request&, clothsim::Step::Response&);
  /// Simulates the request's frames. Returns an error message; empty: success.
  std::string simulate_frames(const clothsim::Step::Request&);

  ros::CallbackQueue& queue_;
  std::function<bool()> ends_;
  TimeShares time_;
  TimedCallbacks callbacks_;
  ros::NodeHandle node_;
  NodeParameters parameters_;
  clothsim::Simulator simulator_;
  clothsim::StepReport report_;     // of the last frame
  std::uint64_t frame_number_ = 0;  // since the scene's start
  bool paused_;
  std::string failure_;  // why the simulation stopped

  Pacer pacer_;
  Changes changes_;
  TfListener tf_;
  StepTargets targets_;
  FrameFollower follower_;
  Grasper grasper_;
  Outputs outputs_;
  ContactTopics contact_topics_;
  Cameras cameras_;
  BodyTopics body_topics_;
  std::optional<Reconfigure> reconfigure_;           // for the scene
  std::optional<ViewReconfigure> view_reconfigure_;  // for the scene's colliders
  RateMeter rate_;
  StateServices state_services_;
  StressTopic stress_topic_;
  WindListener wind_listener_;
  ForceListener force_listener_;
  Diagnostics diagnostics_;
  ChoiceLog choice_log_;
  NearFrames near_frames_;
  ros::SteadyTime next_diagnostics_;

  ros::Publisher clock_publisher_;  // set where the node owns the clock
  std::vector<ros::ServiceServer> services_;
};

}  // namespace clothsim_ros
