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

/// Moves the tf frames that a call of ~step gives targets for. tf has them in time for each frame
/// of simulation. Others hear of them when it is done, and with each one from then on, until
/// another node moves them; who begins to listen later, hears of them at once.
class StepTargets {
 public:
  /// `tf` must outlive this. `node`: whose queue serves those who begin to listen.
  StepTargets(const ros::NodeHandle& node, TfListener& tf) : tf_(tf), node_(node) {}

  /// Sets out for the targets of a call. `followed`: frames that something of the node follows; a
  /// target that carries none of them is logged, once. Throws InvalidValue and changes nothing.
  void set_targets(const clothsim::Step::Request&, const clothsim::Simulator&,
                   const std::vector<std::string>& followed);

  /// Hands the poses at the end of the next frame of simulation to tf.
  void advance();

  /// Tells others of the poses after a frame of simulation, or a jump.
  void broadcast(const ros::Time& stamp);

  /// The call has ended, also before its targets were reached. Frames stay where they are.
  void stop() { moving_.clear(); }

  /// Frames that nobody else has moved since go back to where the scene has the collider that
  /// follows them, others to where they began.
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
  Saved motions_;                                // of all frames that were ever told, by name
  std::map<std::string, clothsim::Pose> begin_;  // where each was then
  std::vector<std::string> moving_;              // in this call
  std::set<std::string> strangers_;              // that were told
  ros::Time stamp_;                              // of the last frame
};

}  // namespace clothsim_ros
