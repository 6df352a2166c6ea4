#pragma once

#include <std_msgs/Header.h>
#include <visualization_msgs/MarkerArray.h>

#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// All that RViz shows of a simulation, in namespaces surface, structural, shear, bending,
/// colliders and pins. Ids do not change, so each array replaces the one before; a spring family
/// or a collider that is switched off is deleted.
visualization_msgs::MarkerArray make_markers(const clothsim::Simulator&, const std_msgs::Header&);

}  // namespace clothsim_ros
