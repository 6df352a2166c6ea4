#pragma once

namespace clothsim_ros {

/// Makes SIGTERM, which ends services and containers, shut the node down as roscpp lets SIGINT do.
/// To be called after ros::init.
void shut_down_on_sigterm();

}  // namespace clothsim_ros
