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
#include "clothsim/ros/timed_callbacks.h"
#include "clothsim/ros/view_reconfigure.h"
#include "clothsim/ros/wind_listener.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// A simulated cloth as a ROS node or nodelet. One thread serves the callbacks and, between them,
/// computes the frames, so nothing changes inside a frame.
class Node {
 public:
  /// `node` has the names of topics, services and parameters, `queue` the callbacks: nobody else
  /// may call them. The node ends when `ends` says so. Throws std::runtime_error with the full name
  /// of a bad parameter.
  Node(const ros::NodeHandle& node, ros::CallbackQueue& queue, std::function<bool()> ends);

  /// Simulates until the node is shut down. In the thread that has made it.
  void run();

 private:
  /// A frame that is due by the clock, or one out of turn, from ~step.
  enum class Turn { due, now };

  /// Simulates the frame that is due, and publishes what is.
  void go_on();
  /// Calls `action` in a thread of its own, and goes on with frames until it has ended. Throws what
  /// it throws. Callbacks wait.
  void go_on_beside(const std::function<void()>& action);
  /// False when all is closed, closing begins or the node is to end.
  bool is_running() const;
  /// Calls the callbacks that are there, or that come within `wait`.
  void serve(ros::WallDuration wait);
  /// Computes a frame and publishes it. False if it diverged; then the simulation is paused.
  bool simulate_frame(Turn);
  void publish_frame(const ros::Time& stamp);
  /// Publishes what is due between frames.
  void refresh();
  /// The simulator is in another state, without a frame between.
  void jump();
  void publish_clock();
  void serve_live_values();
  /// Loads another scene, seen as ~camera had it at the node's start. Throws InvalidValue and
  /// changes nothing where one of the two is refused.
  void start_with(const clothsim::Scene&);
  /// Warns of private parameters that were `given` for nothing, once live values are served.
  void warn_of_ignored(const ParameterTexts& given) const;
  /// Says what of the scene, as it was `given`, the node leaves to others, what it goes without,
  /// and what may not be meant.
  void warn_of_scene(const YAML::Node& given) const;
  void publish_diagnostics();
  /// Frames of tf that carry colliders, points or cameras.
  std::vector<std::string> followed_frames() const;

  bool pause(std_srvs::SetBool::Request&, std_srvs::SetBool::Response&);
  bool reset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response&);
  bool reset_values(std_srvs::Trigger::Request&, std_srvs::Trigger::Response&);
  bool enable_collider(clothsim::EnableCollider::Request&, clothsim::EnableCollider::Response&);
  bool load_scene(clothsim::LoadScene::Request&, clothsim::LoadScene::Response&);
  bool step(clothsim::Step::Request&, clothsim::Step::Response&);
  /// Simulates its frames. Empty: it did; else why not.
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
  std::optional<Reconfigure> reconfigure_;           // of the scene
  std::optional<ViewReconfigure> view_reconfigure_;  // of the scene's colliders
  RateMeter rate_;
  StateServices state_services_;
  StressTopic stress_topic_;
  WindListener wind_listener_;
  ForceListener force_listener_;
  Diagnostics diagnostics_;
  ChoiceLog choice_log_;
  NearFrames near_frames_;
  ros::SteadyTime next_diagnostics_;

  ros::Publisher clock_publisher_;  // where the node owns the clock
  std::vector<ros::ServiceServer> services_;
};

}  // namespace clothsim_ros
