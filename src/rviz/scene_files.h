#pragma once

#include <xmlrpcpp/XmlRpcValue.h>

#include <string>
#include <vector>

namespace clothsim_rviz {

/// Which of the files holds the scene of a parameter; empty: none.
std::string file_of(const XmlRpc::XmlRpcValue& scene, const std::vector<std::string>& files);

}  // namespace clothsim_rviz
