#include <ros/callback_queue.h>
#include <ros/console.h>
#include <ros/init.h>
#include <ros/master.h>

#include <cstdlib>
#include <exception>

#include "clothsim/ros/node.h"
#include "clothsim/ros/signals.h"

namespace {

/// How long a call waits for a master that is away, before it gives up. Frames wait with it.
const ros::WallDuration master_patience(0.001);

}  // namespace

int main(int argc, char** argv) {
  int exit_code = EXIT_SUCCESS;
  try {
    clothsim_ros::shut_down_on_signals();
    ros::init(argc, argv, "clothsim", ros::init_options::NoSigintHandler);
    ros::start();  // rather than by the node's own handle: the log outlives a node that fails
    clothsim_ros::end_in_order_on_signals();
    if (!clothsim_ros::is_interrupted()) {  // while it waited for a master
      clothsim_ros::Node node(ros::NodeHandle("~"), *ros::getGlobalCallbackQueue(),
                              clothsim_ros::is_interrupted);
      ros::master::setRetryTimeout(master_patience);
      node.run();
    }
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    exit_code = EXIT_FAILURE;
  }
  ros::shutdown();  // also waits for one that is under way
  return exit_code;
}
