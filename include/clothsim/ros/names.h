#pragma once

#include <set>
#include <string>

namespace clothsim_ros {

/// `name` as a part of a ROS name: other letters become underscores, and `prefix` goes before it
/// where it does not start with a letter.
std::string to_ros_name(std::string name, const std::string& prefix);

/// The name of a collider as a part of a ROS name that is not in `taken`, which it is added to.
std::string free_ros_name(const std::string& collider, std::set<std::string>& taken);

}  // namespace clothsim_ros
