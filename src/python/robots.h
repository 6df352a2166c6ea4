#pragma once

#include <map>
#include <memory>
#include <string>

#include "simulation.h"

namespace clothsim_python {

/// clothsim.Robot: the joints of a robot in a simulator.
class Robot {
 public:
  Robot(std::shared_ptr<Simulation> simulation, std::string name)
      : simulation_(std::move(simulation)), name_(std::move(name)) {}

  const std::string& name() const { return name_; }

  /// By name: {'position', 'lower', 'upper'}.
  py::dict joints() const;

  /// Puts the frames of its links at once at their poses for these joint values.
  void set_joints(const clothsim::JointValues&) const;

  /// The poses of its links' frames for these values, as targets of step().
  py::dict targets(const clothsim::JointValues&) const;

 private:
  std::shared_ptr<Simulation> simulation_;
  std::string name_;
};

/// The robots of the scene, by name; a robot with a name that is taken, by name and prefix.
std::map<std::string, Robot> robots_of(const std::shared_ptr<Simulation>&);

}  // namespace clothsim_python
