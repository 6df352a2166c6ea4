#pragma once

#include <xmlrpcpp/XmlRpcValue.h>

#include <string>
#include <vector>

namespace clothsim_rviz {

/// The one of the files that holds the scene of a parameter; empty: none.
std::string file_of(const XmlRpc::XmlRpcValue& scene, const std::vector<std::string>& files);

}  // namespace clothsim_rviz
