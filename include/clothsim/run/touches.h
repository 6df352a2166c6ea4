#pragma once

#include <vector>

#include "clothsim/simulation/simulator.h"

namespace clothsim {

/// Where the cloth lies on a collider.
struct Touch {
  int count = 0;            // of points, and of triangles that touch with none of their corners
  Vector3 middle{0, 0, 0};  // mean of these places [m]; the origin where there is none
};

/// One for each collider, by the state as it is: what is within 0.1 mm of where contact holds it.
/// Nothing touches a collider that is off.
std::vector<Touch> find_touches(const Simulator&);

}  // namespace clothsim
