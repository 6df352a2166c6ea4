#include <ros/init.h>
#include <ros/node_handle.h>

#include <string>
#include <vector>

#include "clothsim/ros/handles.h"

int main(int argc, char** argv) {
  // Wall time, whatever /use_sim_time says: the library's time-outs are to pass while the clock
  // stands. So the node looks for that parameter where it is not.
  std::string wall_time = "/use_sim_time:=/clothsim_handles_on_wall_time";
  std::vector<char*> arguments(argv, argv + argc);
  arguments.push_back(wall_time.data());
  int count = static_cast<int>(arguments.size());
  arguments.push_back(nullptr);

  ros::init(count, arguments.data(), "clothsim_handles");
  ros::start();
  if (!ros::ok()) return 0;  // interrupted while it waited for a master
  const ros::NodeHandle cloth(ros::NodeHandle("~").param<std::string>("cloth", "/clothsim"));
  clothsim_ros::Handles handles(cloth);
  ros::spin();
}
