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

std::vector<std::string> ros_names(const std::vector<clothsim::ColliderSpec>& colliders,
                                   std::set<std::string> taken) {
  std::vector<std::string> names(colliders.size());
  for (const bool as_it_is : {true, false}) {
    for (std::size_t i = 0; i < colliders.size(); ++i) {
      std::string name = to_ros_name(colliders[i].name, "collider_");
      if ((name == colliders[i].name) != as_it_is) continue;
      while (!taken.insert(name).second) name += "_";
      names[i] = name;
    }
  }
  return names;
}

}  // namespace clothsim_ros
