#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/scene/urdf.h"

namespace clothsim {

/// Joints of a robot by name [rad or m].
using JointValues = std::map<std::string, double>;

/// Where the links of a robot are, by its joints: forward kinematics by Orocos KDL. Joints that
/// mimic follow theirs; those that are neither revolute, continuous nor prismatic stay.
class Kinematics {
 public:
  /// Throws InvalidValue, without a key, for a joint with a fault, and one that mimics none or one
  /// that mimics, too.
  explicit Kinematics(const Urdf&);

  /// Limits of the joints that can be set, by name; empty: a continuous one has none.
  const std::map<std::string, std::optional<Range>>& joints() const { return joints_; }

  /// Throws InvalidValue with the joint as the key: for one that cannot be set, and values beyond
  /// its limits or not finite.
  void check(const JointValues&) const;

  /// Of each link in the root's frame; joints that are not named are at 0. Throws as check().
  std::map<std::string, Pose> poses(const JointValues&) const;

 private:
  struct Impl;
  std::map<std::string, std::optional<Range>> joints_;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace clothsim
