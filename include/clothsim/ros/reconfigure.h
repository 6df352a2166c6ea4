#pragma once

#include <dynamic_reconfigure/Config.h>
#include <ros/node_handle.h>

#include <memory>
#include <string>
#include <vector>

#include "clothsim/ros/changes.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// Values of cloth and simulation that dynamic_reconfigure changes, and of each collider in the
/// namespace collider/NAME. They are applied in the thread
/// that serves the node's callbacks, so between two frames of the simulator.
class Reconfigure {
 public:
  /// Starts from the simulator's values, whatever an earlier node left on the parameter server.
  /// Simulator and Changes must outlive this. Another method has its defaults for parameters; that
  /// of the start has those of the start again. A request with a value that the simulator refuses
  /// changes nothing, is logged, and is answered with the values that hold.
  Reconfigure(const ros::NodeHandle&, clothsim::Simulator&, Changes&);
  ~Reconfigure();

  /// All of them, those of colliders by the names that names() has.
  dynamic_reconfigure::Config values() const;

  /// Theirs, below the node's.
  std::vector<std::string> names() const;

  /// Those that differ from the scene's, as "name value".
  std::vector<std::string> changed() const;

  /// Takes back the changes of requests. Throws the simulator's exceptions.
  void reset();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace clothsim_ros
