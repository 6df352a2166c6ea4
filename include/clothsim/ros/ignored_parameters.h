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

/// The private parameters of a node by use.
struct KnownParameters {
  std::vector<std::string> read;  // at the start, with all below them
  std::vector<std::string> live;  // initial values come from the scene or the view
};

/// A message for each of the parameters that were `given` at the start without effect: an unknown
/// one, or a live value that differs `now`. `prefix` goes before their names.
std::vector<std::string> ignored_parameters(const std::string& prefix, const KnownParameters& known,
                                            const ParameterTexts& given, const ParameterTexts& now);

/// Logs these messages for private parameters of `node`.
void warn_of_ignored_parameters(const ros::NodeHandle& node, const KnownParameters& known,
                                const ParameterTexts& given);

}  // namespace clothsim_ros
