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

/// What the node says of itself.
struct NodeStatus {
  bool paused = false;
  bool waits_for_clock = false;          // not paused, but /clock has not begun
  std::string failure;                   // why the simulation stopped; empty: it did not
  double factor_asked = 1;               // 0: as fast as possible
  std::optional<double> factor_reached;  // empty: nothing to measure
  TimeShares::Shares time;
  clothsim::StepReport report;  // of the last frame
  std::vector<clothsim::HolderReport> holders;
  std::optional<double> strain_limit;     // empty: off
  std::optional<int> intersecting_pairs;  // of triangles; empty: no self collision asked for
  std::vector<FrameStatus> frames;
  std::vector<CameraStatus> cameras;
};

/// Sends a NodeStatus to /diagnostics, and tells the log what is new in it.
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
