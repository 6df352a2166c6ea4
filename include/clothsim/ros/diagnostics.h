#pragma once

#include <ros/node_handle.h>

#include <optional>
#include <string>
#include <vector>

#include "clothsim/ros/diagnostic_limits.h"
#include "clothsim/ros/photographer.h"
#include "clothsim/ros/time_shares.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// The node's state for diagnostics.
struct NodeStatus {
  bool paused = false;
  bool waits_for_clock = false;          // not paused, but /clock has not begun
  std::string failure;                   // why the simulation stopped; empty: running
  double factor_asked = 1;               // 0: as fast as possible
  std::optional<double> factor_reached;  // empty: nothing to measure
  TimeShares::Shares time;
  clothsim::StepReport report;  // of the last frame
  std::vector<clothsim::HolderReport> holders;
  bool is_limited = false;                // whether a cloth has a strain limit
  std::optional<int> intersecting_pairs;  // of triangles; empty: no self collision requested
  std::vector<FrameStatus> frames;
  std::vector<CameraStatus> cameras;
};

/// Publishes a NodeStatus on /diagnostics, and logs its changes.
class Diagnostics {
 public:
  Diagnostics(ros::NodeHandle&, const DiagnosticLimits&);

  void publish(const NodeStatus&);

 private:
  std::string name_;  // of the node
  DiagnosticLimits limits_;
  NodeStatus status_;  // the last one
  ros::Publisher publisher_;
};

}  // namespace clothsim_ros
