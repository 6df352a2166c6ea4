#pragma once

#include <clothsim/Attach.h>
#include <clothsim/Detach.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <map>
#include <string>
#include <vector>

#include "clothsim/ros/changes.h"
#include "clothsim/ros/tf_frame.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// The services ~attach and ~detach and the topics ~wrench/FRAME. The simulator's grips are named
/// after their tf frames. A frame that is lost holds its points where they are.
class Grasper {
 public:
  /// Simulator, `tf` and Changes must outlive this.
  Grasper(const ros::NodeHandle&, clothsim::Simulator&, TfListener& tf, Changes&);

  /// Reads the latest transforms.
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
  const ros::Publisher& publisher_of(const std::string& frame);
  /// Throws InvalidValue where another frame that carries points has the topic of `frame`.
  void check_topic(const std::string& frame) const;
  /// Those that nothing holds yet. Throws InvalidValue where there is none.
  std::vector<int> free_points_near(const clothsim::Vector3& position, double radius) const;

  ros::NodeHandle node_;
  clothsim::Simulator& simulator_;
  TfListener& tf_;
  Changes& changes_;
  std::map<std::string, TfFrame> frames_;  // of the simulator's grips
  // By topic, kept: a subscriber may miss that a topic goes and comes again.
  std::map<std::string, ros::Publisher> publishers_;
  std::vector<ros::ServiceServer> services_;
};

}  // namespace clothsim_ros
