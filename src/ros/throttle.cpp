#include "clothsim/ros/throttle.h"

namespace clothsim_ros {

bool Throttle::passes() {
  const ros::SteadyTime now = ros::SteadyTime::now();
  if (now < next_) return false;
  next_ = now + period_;
  return true;
}

}  // namespace clothsim_ros
