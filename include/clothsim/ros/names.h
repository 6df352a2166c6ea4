#pragma once

#include <set>
#include <string>
#include <vector>

#include "clothsim/model/cloth_spec.h"
#include "clothsim/shapes/collider.h"

namespace clothsim_ros {

/// `name` as a part of a ROS name: invalid characters become underscores, and `prefix` goes before
/// it where it does not start with a letter.
std::string to_ros_name(std::string name, const std::string& prefix);

/// The names of colliders, or of several cloths, as parts of ROS names, all different and none in
/// `taken`. Valid names are kept; in others invalid characters are replaced. Underscores are
/// appended where the result is taken.
std::vector<std::string> ros_names(const std::vector<clothsim::ColliderSpec>& colliders,
                                   std::set<std::string> taken = {});
std::vector<std::string> ros_names(const std::vector<clothsim::ClothPart>& cloths,
                                   std::set<std::string> taken = {});

}  // namespace clothsim_ros
