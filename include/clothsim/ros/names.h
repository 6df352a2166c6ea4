#pragma once

#include <set>
#include <string>
#include <vector>

#include "clothsim/shapes/collider.h"

namespace clothsim_ros {

/// `name` as a part of a ROS name: other letters become underscores, and `prefix` goes before it
/// where it does not start with a letter.
std::string to_ros_name(std::string name, const std::string& prefix);

/// The names of colliders as parts of ROS names, each another one and none in `taken`: those that
/// may stand as they are do so, of others letters are replaced, with underscores after them where
/// that is taken.
std::vector<std::string> ros_names(const std::vector<clothsim::ColliderSpec>& colliders,
                                   std::set<std::string> taken = {});

}  // namespace clothsim_ros
