#include <ros/callback_queue.h>
#include <ros/console.h>
#include <ros/init.h>
#include <ros/master.h>
#include <ros/this_node.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <cstdlib>
#include <exception>
#include <string>

#include "clothsim/ros/node.h"
#include "clothsim/ros/signals.h"

namespace {

/// How long a call waits for a missing master before it fails. Frames wait with it.
const ros::WallDuration master_patience(0.001);

/// The registered node of the same name, which ends when this one registers; empty: there is none.
std::string namesake() {
  XmlRpc::XmlRpcValue request;
  XmlRpc::XmlRpcValue answer;
  XmlRpc::XmlRpcValue uri;
  request[0] = ros::this_node::getName();
  request[1] = ros::this_node::getName();
  if (!ros::master::execute("lookupNode", request, answer, uri, false)) return "";
  return static_cast<std::string>(uri);
}

}  // namespace

int main(int argc, char** argv) {
  int exit_code = EXIT_SUCCESS;
  try {
    clothsim_ros::shut_down_on_signals();
    ros::init(argc, argv, "clothsim", ros::init_options::NoSigintHandler);
    const std::string other = namesake();
    ros::start();  // not by the node's own handle, so that the log outlives a node that fails
    clothsim_ros::end_in_order_on_signals();
    if (!other.empty()) {
      ROS_WARN(
          "The node %s at %s ends now, if it still runs: two cannot have one name; did you mean "
          "__name:=another?",
          ros::this_node::getName().c_str(), other.c_str());
    }
    if (!clothsim_ros::is_interrupted()) {  // false: interrupted while waiting for a master
      clothsim_ros::Node node(ros::NodeHandle("~"), *ros::getGlobalCallbackQueue(),
                              clothsim_ros::is_interrupted);
      ros::master::setRetryTimeout(master_patience);
      node.run();
    }
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    exit_code = EXIT_FAILURE;
  }
  ros::shutdown();  // waits also for a shutdown in progress
  return exit_code;
}
