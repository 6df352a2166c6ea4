#include "clothsim/ros/names.h"

#include <algorithm>
#include <cctype>
#include <utility>

namespace clothsim_ros {

std::string to_ros_name(std::string name, const std::string& prefix) {
  std::replace_if(
      name.begin(), name.end(),
      [](unsigned char c) { return c >= 128 || (!std::isalnum(c) && c != '_'); }, '_');
  if (!std::isalpha(static_cast<unsigned char>(name[0]))) name = prefix + name;
  return name;
}

std::vector<std::string> ros_names(const std::vector<std::string>& all, const std::string& prefix,
                                   std::set<std::string> taken) {
  std::vector<std::string> names(all.size());
  for (const bool as_it_is : {true, false}) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      std::string name = to_ros_name(all[i], prefix);
      if ((name == all[i]) != as_it_is) continue;
      while (!taken.insert(name).second) name += "_";
      names[i] = name;
    }
  }
  return names;
}

std::vector<std::string> ros_names(const std::vector<clothsim::ColliderSpec>& colliders,
                                   std::set<std::string> taken) {
  std::vector<std::string> all;
  for (const clothsim::ColliderSpec& collider : colliders) all.push_back(collider.name);
  return ros_names(all, "collider_", std::move(taken));
}

std::vector<std::string> ros_names(const std::vector<clothsim::ClothPart>& cloths) {
  std::vector<std::string> all;
  for (const clothsim::ClothPart& cloth : cloths) all.push_back(cloth.name);
  return ros_names(all, "cloth_");
}

}  // namespace clothsim_ros
