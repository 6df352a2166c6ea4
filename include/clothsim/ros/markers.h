#pragma once

#include <std_msgs/Header.h>
#include <visualization_msgs/MarkerArray.h>

#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

// What RViz shows of a simulation. Ids do not change, so each array replaces the one before; a
// spring family or a collider that is switched off is deleted.

/// In namespaces surface, colliders and pins.
visualization_msgs::MarkerArray make_markers(const clothsim::Simulator&, const std_msgs::Header&);

/// In namespaces structural, shear and bending.
visualization_msgs::MarkerArray make_spring_markers(const clothsim::Simulator&,
                                                    const std_msgs::Header&);

/// In namespace colliders.
visualization_msgs::MarkerArray make_collider_markers(const clothsim::Simulator&,
                                                      const std_msgs::Header&);

}  // namespace clothsim_ros
