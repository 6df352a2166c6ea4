#pragma once

#include <vector>

#include "clothsim/simulation/simulator.h"

namespace clothsim {

/// Contact of the cloth with a collider.
struct Touch {
  int count = 0;            // points, and triangles in contact between their corners
  Vector3 middle{0, 0, 0};  // mean position of the contacts [m]; the origin without contacts
  double area = 0;          // of the cloth that touches: the points' own areas [m^2]
};

/// The touch of each collider in the present state: points and triangles within 0.1 mm of the
/// contact distance. None for a disabled collider.
std::vector<Touch> find_touches(const Simulator&);

}  // namespace clothsim
