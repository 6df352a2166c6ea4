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
#include "clothsim/ros/jumps.h"
#include "clothsim/ros/pacer.h"
#include "clothsim/ros/tf_frame.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// The services ~attach and ~detach and the topics ~wrench/FRAME. The simulator's grips have the
/// names of their tf frames. A frame that is lost holds its points in place. Wrenches are published
/// for subscribers only: one a frame, the latest one for a new subscriber, and a last one of zero
/// when the frame has released its points.
class Grasper {
 public:
  /// Simulator, `tf`, Changes and Pacer must outlive this. `jump_speed` [m/s] bounds the speed of
  /// points.
  Grasper(const ros::NodeHandle&, clothsim::Simulator&, TfListener& tf, Changes&, const Pacer&,
          double jump_speed);

  /// Reads the latest transforms. To be called also while the simulation is paused.
  void look_up();

  /// Passes the poses of look_up() to the simulator, for its next frame, and publishes them.
  void move();

  /// To be called after each frame. Publishes the wrenches, each in its frame.
  void update(const ros::Time& stamp);

  /// To be called when the simulator may have other grips without a frame in between.
  void follow_grips();

  /// Holds a body with a tf frame. Throws InvalidValue.
  void attach_body(int body, const std::string& frame);
  /// Lets it go. Throws InvalidValue.
  void detach_body(int body);

  /// The status of each frame that holds points.
  std::vector<FrameStatus> status() const;

 private:
  bool attach(clothsim::Attach::Request&, clothsim::Attach::Response&);
  bool detach(clothsim::Detach::Request&, clothsim::Detach::Response&);

  struct WrenchTopic {
    ros::Publisher publisher;
    std::string frame;
    std::optional<ros::Time> stamp;         // of the frame's last wrench; empty: none so far
    std::optional<ros::SteadyTime> let_go;  // when the frame released its points; empty: it has not
  };

  /// Advertises the topic of a frame that holds points.
  void take_hold(const std::string& frame);
  void let_go(WrenchTopic&);
  void greet(const WrenchTopic&, const ros::SingleSubscriberPublisher&) const;
  /// Removes topics whose frames released their points a while ago.
  void end_old_topics();

  /// The body whose tf frame this is, by its name in the scene; else the frame itself.
  std::string body_or_frame(const std::string& frame) const;
  /// The pose of a frame, which may be new to tf. Throws InvalidValue.
  clothsim::Pose first_pose(TfFrame&) const;
  /// Throws InvalidValue where another frame that holds points has the topic of `frame`.
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
