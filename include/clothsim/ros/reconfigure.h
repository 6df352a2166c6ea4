#pragma once

#include <dynamic_reconfigure/Config.h>
#include <ros/node_handle.h>

#include <memory>
#include <string>
#include <vector>

#include "clothsim/ros/changes.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// Values of cloth and simulation that dynamic_reconfigure changes, and those of each collider in
/// the namespace collider/NAME. They are applied in the thread that serves the node's callbacks,
/// thus between two frames of the simulator.
class Reconfigure {
 public:
  /// Starts from the simulator's values, independent of an earlier node's values on the parameter
  /// server. Simulator and Changes must outlive this. Another method gets default parameters; the
  /// initial method gets its initial ones again. A request with a value that the simulator refuses
  /// changes nothing, is logged, and is answered with the values in effect.
  Reconfigure(const ros::NodeHandle&, clothsim::Simulator&, Changes&);
  ~Reconfigure();

  /// All values, those of colliders by names as in names().
  dynamic_reconfigure::Config values() const;

  /// The names of all values, below the node's.
  std::vector<std::string> names() const;

  /// The values that differ from the scene's, as "name value".
  std::vector<std::string> changed() const;

  /// Undoes the changes of requests. Throws the simulator's exceptions.
  void reset();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace clothsim_ros
