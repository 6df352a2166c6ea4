#include <ros/console.h>
#include <ros/init.h>
#include <ros/node_handle.h>

#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include "clothsim/ros/handles.h"
#include "clothsim/ros/ignored_parameters.h"
#include "clothsim/ros/parameters.h"
#include "clothsim/ros/signals.h"

int main(int argc, char** argv) {
  // Use wall time even with /use_sim_time: the library's time-outs must pass while the clock
  // stands. So this node looks for that parameter under a name where it is not set.
  std::string wall_time = "/use_sim_time:=/clothsim_handles_on_wall_time";
  std::vector<char*> arguments(argv, argv + argc);
  arguments.push_back(wall_time.data());
  int count = static_cast<int>(arguments.size());
  arguments.push_back(nullptr);

  int exit_code = EXIT_SUCCESS;
  try {
    clothsim_ros::shut_down_on_signals();
    ros::init(count, arguments.data(), "clothsim_handles", ros::init_options::NoSigintHandler);
    ros::start();     // not by a handle, so that the log outlives a node that fails
    if (ros::ok()) {  // false: interrupted while waiting for a master
      const ros::NodeHandle node("~");
      const ros::NodeHandle cloth(clothsim_ros::read_cloth_parameter(node));
      clothsim_ros::warn_of_ignored_parameters(node, {{"cloth"}, {}},
                                               clothsim_ros::parameter_texts(node));
      clothsim_ros::Handles handles(cloth);
      ros::spin();
    }
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    exit_code = EXIT_FAILURE;
  }
  ros::shutdown();
  return exit_code;
}
