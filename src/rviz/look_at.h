#pragma once

#include <Eigen/Geometry>

namespace rviz {
class ViewController;
}  // namespace rviz

namespace clothsim_rviz {

/// Moves an orbiting camera of RViz, without a change of its direction, so that it sees all of a
/// box of the fixed frame [m]. Cameras of other kinds are not moved.
void look_at(rviz::ViewController&, const Eigen::AlignedBox3d&);

}  // namespace clothsim_rviz
