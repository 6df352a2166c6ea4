#pragma once

#include <string>

namespace clothsim_ros {

/// `name` as a part of a ROS name: other letters become underscores, and `prefix` goes before it
/// where it does not start with a letter.
std::string to_ros_name(std::string name, const std::string& prefix);

}  // namespace clothsim_ros
