#pragma once

namespace clothsim_ros {

/// Lets SIGINT and SIGTERM shut ROS down, also while it waits for a master. A thread of its own
/// handles them, so that they interrupt no call of another thread. To be called before ros::init,
/// without roscpp's own handler.
void shut_down_on_signals();

/// Lets the first signal only set is_interrupted(), so that the node can end between two steps of
/// its work: ROS, if shut down by its own thread meanwhile, aborts a node that still publishes.
void end_in_order_on_signals();

/// Whether a signal has come.
bool is_interrupted();

}  // namespace clothsim_ros
