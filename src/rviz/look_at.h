#pragma once

#include <Eigen/Geometry>

namespace rviz {
class ViewController;
}  // namespace rviz

namespace clothsim_rviz {

/// Moves an orbiting camera of RViz, which keeps its direction, so that it sees all of a box of the
/// fixed frame [m]. Cameras of other kinds stay where they are.
void look_at(rviz::ViewController&, const Eigen::AlignedBox3d&);

}  // namespace clothsim_rviz
