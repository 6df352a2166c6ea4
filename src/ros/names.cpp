#include "clothsim/ros/names.h"

#include <algorithm>
#include <cctype>
#include <utility>

namespace clothsim_ros {
namespace {

template <typename Named>
std::vector<std::string> names_of(const std::vector<Named>& all, const std::string& prefix,
                                  std::set<std::string> taken) {
  std::vector<std::string> names(all.size());
  for (const bool as_it_is : {true, false}) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      std::string name = to_ros_name(all[i].name, prefix);
      if ((name == all[i].name) != as_it_is) continue;
      while (!taken.insert(name).second) name += "_";
      names[i] = name;
    }
  }
  return names;
}

}  // namespace

std::string to_ros_name(std::string name, const std::string& prefix) {
  std::replace_if(
      name.begin(), name.end(),
      [](unsigned char c) { return c >= 128 || (!std::isalnum(c) && c != '_'); }, '_');
  if (!std::isalpha(static_cast<unsigned char>(name[0]))) name = prefix + name;
  return name;
}

std::vector<std::string> ros_names(const std::vector<clothsim::ColliderSpec>& colliders,
                                   std::set<std::string> taken) {
  return names_of(colliders, "collider_", std::move(taken));
}

std::vector<std::string> ros_names(const std::vector<clothsim::ClothPart>& cloths,
                                   std::set<std::string> taken) {
  return names_of(cloths, "cloth_", std::move(taken));
}

}  // namespace clothsim_ros
