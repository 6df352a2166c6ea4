#include <ros/console.h>
#include <ros/init.h>

#include <cstdlib>
#include <exception>

#include "clothsim/ros/node.h"

int main(int argc, char** argv) {
  try {
    ros::init(argc, argv, "clothsim");
    clothsim_ros::Node node;
    node.run();
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
