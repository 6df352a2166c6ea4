#include "clothsim/ros/names.h"

#include <algorithm>
#include <cctype>

namespace clothsim_ros {

std::string to_ros_name(std::string name, const std::string& prefix) {
  std::replace_if(
      name.begin(), name.end(),
      [](unsigned char c) { return c >= 128 || (!std::isalnum(c) && c != '_'); }, '_');
  if (!std::isalpha(static_cast<unsigned char>(name[0]))) name = prefix + name;
  return name;
}

std::string free_ros_name(const std::string& collider, std::set<std::string>& taken) {
  std::string name = to_ros_name(collider, "collider_");
  while (!taken.insert(name).second) name += "_";
  return name;
}

}  // namespace clothsim_ros
