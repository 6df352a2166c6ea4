#pragma once

#include <clothsim/Attach.h>
#include <clothsim/Detach.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/ros/changes.h"
#include "clothsim/ros/pacer.h"
#include "clothsim/ros/speed_limit.h"
#include "clothsim/ros/tf_frame.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// The services ~attach and ~detach and the topics ~wrench/FRAME. The simulator's grips are named
/// after their tf frames. A frame that is lost holds its points where they are. Wrenches are made
/// for subscribers alone: one a frame, the present one for a new subscriber, and a last one of zero
/// when the frame has let go.
class Grasper {
 public:
  /// Simulator, `tf`, Changes and Pacer must outlive this. Points follow their frames at no more
  /// than `jump_speed` [m/s].
  Grasper(const ros::NodeHandle&, clothsim::Simulator&, TfListener& tf, Changes&, const Pacer&,
          double jump_speed);

  /// Reads the latest transforms. To be called also while nothing is simulated.
  void look_up();

  /// Hands what look_up() found to the simulator, for its next frame, and tells of it.
  void move();

  /// A frame has been simulated. Publishes the wrenches, each in its frame.
  void update(const ros::Time& stamp);

  /// To be called when the simulator may have other grips, without a frame between.
  void follow_grips();

  /// One for each frame that carries points.
  std::vector<FrameStatus> status() const;

 private:
  bool attach(clothsim::Attach::Request&, clothsim::Attach::Response&);
  bool detach(clothsim::Detach::Request&, clothsim::Detach::Response&);

  struct WrenchTopic {
    ros::Publisher publisher;
    std::string frame;
    std::optional<ros::Time> stamp;         // of the frame's last wrench; empty: there is none yet
    std::optional<ros::SteadyTime> let_go;  // when the frame did; empty: it holds points
  };

  /// Serves the topic of a frame that holds points.
  void take_hold(const std::string& frame);
  void let_go(WrenchTopic&);
  void greet(const WrenchTopic&, const ros::SingleSubscriberPublisher&) const;
  /// Takes topics back whose frames let go a while ago.
  void end_old_topics();

  /// Throws InvalidValue where another frame that carries points has the topic of `frame`.
  void check_topic(const std::string& frame) const;

  ros::NodeHandle node_;
  clothsim::Simulator& simulator_;
  TfListener& tf_;
  Changes& changes_;
  const Pacer& pacer_;
  SpeedLimit speed_limit_;
  std::map<std::string, TfFrame> frames_;      // of the simulator's grips
  std::map<std::string, WrenchTopic> topics_;  // by name
  std::vector<ros::ServiceServer> services_;
};

}  // namespace clothsim_ros
