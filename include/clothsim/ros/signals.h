#pragma once

namespace clothsim_ros {

/// From now on SIGINT and SIGTERM shut ROS down, also while it waits for a master. A thread of its
/// own takes them, so that they break off no call of another. To be called before ros::init, with
/// no roscpp handler of its own.
void shut_down_on_signals();

/// From now on the first one only sets is_interrupted(), for the node to end between two steps of
/// its work: ROS, shut down meanwhile by its own thread, aborts a node that goes on to publish.
void end_in_order_on_signals();

/// Whether one of them came.
bool is_interrupted();

}  // namespace clothsim_ros
