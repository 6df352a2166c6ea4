#include <ros/console.h>
#include <ros/init.h>

#include <cstdlib>
#include <exception>

#include "clothsim/ros/node.h"
#include "clothsim/ros/signals.h"

int main(int argc, char** argv) {
  int exit_code = EXIT_SUCCESS;
  try {
    ros::init(argc, argv, "clothsim");
    clothsim_ros::shut_down_on_sigterm();
    ros::start();     // rather than by the node's own handle: the log outlives a node that fails
    if (ros::ok()) {  // not interrupted while it waited for a master
      clothsim_ros::Node node;
      node.run();
    }
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    exit_code = EXIT_FAILURE;
  }
  ros::shutdown();  // also waits for one that is under way
  return exit_code;
}
