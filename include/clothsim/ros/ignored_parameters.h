#pragma once

#include <ros/node_handle.h>

#include <map>
#include <string>
#include <vector>

namespace clothsim_ros {

/// Values by their names below a node's, such as "scene/cloth/ks", as messages show them.
using ParameterTexts = std::map<std::string, std::string>;

/// The private parameters of `node` that the parameter server has now.
ParameterTexts parameter_texts(const ros::NodeHandle& node);

/// What a node makes of its private parameters.
struct KnownParameters {
  std::vector<std::string> read;  // at the start, with all below them
  std::vector<std::string> live;  // that start as the scene or the view has them
};

/// A message for each of the parameters that were `given` at the start and had no effect: it is
/// unknown, or a live value that is another one `now`. `prefix` goes before their names.
std::vector<std::string> ignored_parameters(const std::string& prefix, const KnownParameters& known,
                                            const ParameterTexts& given, const ParameterTexts& now);

/// Logs these messages for private parameters of `node`.
void warn_of_ignored_parameters(const ros::NodeHandle& node, const KnownParameters& known,
                                const ParameterTexts& given);

}  // namespace clothsim_ros
