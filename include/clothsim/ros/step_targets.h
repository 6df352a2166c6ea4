#pragma once

#include <clothsim/Step.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <tf2_msgs/TFMessage.h>

#include <map>
#include <set>
#include <string>
#include <vector>

#include "clothsim/ros/tf_frame.h"
#include "clothsim/run/driven_frames.h"

namespace clothsim_ros {

/// Moves the tf frames for which a call of ~step gives targets. tf gets them before each frame of
/// simulation. They are broadcast after that frame and each later one, until another node moves
/// them, and at once for a new subscriber.
class StepTargets {
 public:
  /// `tf` must outlive this. `node`: its queue serves new subscribers.
  StepTargets(const ros::NodeHandle& node, TfListener& tf) : tf_(tf), node_(node) {}

  /// Starts towards the targets of a call. `followed`: frames used by the node; a target that
  /// carries none of them is logged, once. Throws InvalidValue without a change.
  void set_targets(const clothsim::Step::Request&, const clothsim::Simulator&,
                   const std::vector<std::string>& followed);

  /// Passes the poses at the end of the next frame of simulation to tf.
  void advance();

  /// Broadcasts the poses after a frame of simulation, or a jump.
  void broadcast(const ros::Time& stamp);

  /// To be called at the end of a call, even before its targets are reached. Frames stay where they
  /// are.
  void stop() { moving_.clear(); }

  /// Moves frames that no other node has moved since back to the pose of their collider in the
  /// scene, or else to their first pose.
  void reset(const clothsim::Scene&);

  using Saved = std::map<std::string, clothsim::FrameMotion>;
  const Saved& save() const { return motions_; }
  void restore(const Saved&);

 private:
  struct Target {
    std::string frame;
    clothsim::FrameTarget target;
  };

  Target read(const clothsim::Step::Request&, std::size_t index) const;
  clothsim::FrameMotion start(const Target&, const clothsim::Simulator&) const;
  void put(const std::string& frame, const clothsim::Pose&);
  void tell_stranger(const std::string& frame, const std::vector<std::string>& followed);
  tf2_msgs::TFMessage message() const;

  TfListener& tf_;
  ros::NodeHandle node_;
  ros::Publisher publisher_;
  Saved motions_;                                // of all frames with targets so far, by name
  std::map<std::string, clothsim::Pose> begin_;  // first pose of each
  std::vector<std::string> moving_;              // in this call
  std::set<std::string> strangers_;              // that were logged
  ros::Time stamp_;                              // of the last frame
};

}  // namespace clothsim_ros
