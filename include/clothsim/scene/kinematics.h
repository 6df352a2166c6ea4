#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "clothsim/scene/urdf.h"

namespace clothsim {

/// Joint positions of a robot by name [rad or m].
using JointValues = std::map<std::string, double>;

/// Poses of a robot's links from its joint positions: forward kinematics by Orocos KDL. Joints with
/// `mimic` follow theirs; joints that are neither revolute, continuous nor prismatic are fixed.
class Kinematics {
 public:
  /// Throws InvalidValue, without a key, for a joint with a fault, and for one that mimics an
  /// unknown joint or a joint that mimics another.
  explicit Kinematics(const Urdf&);

  /// Limits of the joints that can be set, by name; empty: a continuous joint without limits.
  const std::map<std::string, std::optional<Range>>& joints() const { return joints_; }

  /// Throws InvalidValue with the joint as the key: for a joint that cannot be set, and for values
  /// beyond its limits or not finite.
  void check(const JointValues&) const;

  /// The pose of each link in the root's frame; joints that are not named are at 0. Throws as
  /// check().
  std::map<std::string, Pose> poses(const JointValues&) const;

 private:
  struct Impl;
  std::map<std::string, std::optional<Range>> joints_;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace clothsim
