#pragma once

#include <std_msgs/Header.h>
#include <visualization_msgs/MarkerArray.h>

#include <array>
#include <cstddef>

#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

// Markers of a simulation for RViz. Ids do not change, so each array replaces the last one; spring
// families and colliders that are switched off are deleted.

/// Red, green, blue in [0, 1] of one of several cloths, by its number. After the first they are
/// colours that are easy to tell apart: Wong 2011, "Color blindness", Nature Methods 8.
std::array<float, 3> cloth_color(std::size_t number);

/// Namespaces: surface, of several cloths by their number, colliders and pins.
visualization_msgs::MarkerArray make_markers(const clothsim::Simulator&, const std_msgs::Header&);

/// Namespaces: structural, shear and bending.
visualization_msgs::MarkerArray make_spring_markers(const clothsim::Simulator&,
                                                    const std_msgs::Header&);

/// Namespace: colliders.
visualization_msgs::MarkerArray make_collider_markers(const clothsim::Simulator&,
                                                      const std_msgs::Header&);

}  // namespace clothsim_ros
